"""Models that Blender exports as glTF, and what Blender finds changed in them afterwards.

    blender --background --python blender_exchange.py -- make FOLDER
    blender --background --python blender_exchange.py -- compare FOLDER

`make` writes NAME/NAME.glb for plain and tangents, and NAME/NAME.gltf for plain_parts and
tangents_parts: one mesh of two UV sets below a mirrored, turned and scaled node. The base colour is
on the second set. The tangent-space normal map is on the first; it is a bake of normals that are
smooth over the surface, in Blender's own tangents, so that seams cannot be seen in it.
`compare` reads FOLDER/pairs.json, a list of [file before, file after, roles of pictures that may
differ and must], and writes what it finds wrong to FOLDER/differences.json, a list of texts.
"""
import json
import os
import sys

import bpy
import numpy as np

# Blender 3.4's importer says np.bool, which numpy has no longer.
if not hasattr(np, "bool"):
    np.bool = bool

SIZE = 128
MARGIN = 3  # texels around triangles that are painted too


def smooth_normals(positions, normals):
    """What the normal map stands for: the shading normals, bent by a wave in space."""
    waves = 0.4 * np.sin(2.1 * positions[:, [1, 2, 0]])
    bent = normals + waves
    return bent / np.linalg.norm(bent, axis=1, keepdims=True)


def unwrapped(mesh_object, name, angle, margin):
    layer = mesh_object.data.uv_layers.new(name=name)
    mesh_object.data.uv_layers.active = layer
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=np.radians(angle), island_margin=margin)
    bpy.ops.object.mode_set(mode="OBJECT")


def make_mesh():
    bpy.ops.mesh.primitive_torus_add(major_segments=24, minor_segments=12, generate_uvs=False)
    mesh_object = bpy.context.object
    mesh = mesh_object.data
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.quads_convert_to_tris()
    bpy.ops.mesh.faces_shade_smooth()
    bpy.ops.object.mode_set(mode="OBJECT")
    unwrapped(mesh_object, "relief", 66, 0.04)
    unwrapped(mesh_object, "paint", 40, 0.02)
    mesh.uv_layers.active = mesh.uv_layers["relief"]
    mesh.uv_layers["relief"].active_render = True
    mesh_object.scale = (-1.5, 1.5, 1.5)
    mesh_object.rotation_euler = (0.3, 0.7, -0.4)
    mesh_object.location = (1, 2, 3)
    return mesh_object


def bake_normals(mesh):
    """The normal map, one triangle after another; a texel takes the triangle that it is deepest in."""
    mesh.calc_tangents(uvmap="relief")
    uvs = mesh.uv_layers["relief"].data
    pixels = np.tile(np.array([0.5, 0.5, 1, 1]), (SIZE, SIZE, 1))
    depth = np.full((SIZE, SIZE), -np.inf)
    for polygon in mesh.polygons:
        loops = [mesh.loops[i] for i in polygon.loop_indices]
        corners = np.array([uvs[i].uv for i in polygon.loop_indices]) * SIZE
        low = np.maximum(np.floor(corners.min(0)).astype(int) - MARGIN, 0)
        high = np.minimum(np.ceil(corners.max(0)).astype(int) + MARGIN, SIZE)
        x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
        edges = np.array([corners[1] - corners[0], corners[2] - corners[0]]).T
        b, c = np.linalg.solve(edges, np.array([x.ravel() + 0.5, y.ravel() + 0.5]) - corners[:1].T)
        weights = np.array([1 - b - c, b, c]).T
        lengths = np.linalg.norm(np.roll(corners, -1, 0) - np.roll(corners, -2, 0), axis=1)
        heights = abs(np.linalg.det(edges)) / lengths
        inside = (weights * heights).min(1).reshape(x.shape)
        better = (inside > depth[y, x]) & (inside > -MARGIN)
        of = lambda values: weights @ np.array(values)
        normal = of([loop.normal for loop in loops])
        unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        target = smooth_normals(of([mesh.vertices[loop.vertex_index].co for loop in loops]), unit)
        # As MikkTSpace wants it: frames are interpolated, and not made orthogonal again.
        tangent = of([loop.tangent for loop in loops])
        signs = of([[loop.bitangent_sign] for loop in loops])
        bitangent = np.sign(signs) * np.cross(normal, tangent)
        frames = np.stack([tangent, bitangent, normal], axis=2)
        slopes = np.linalg.solve(frames, target[:, :, None])[:, :, 0]
        slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
        pixels[y[better], x[better], :3] = (slopes.reshape(*x.shape, 3)[better] + 1) / 2
        depth[y[better], x[better]] = inside[better]
    mesh.free_tangents()
    return pixels


def picture(name, pixels, folder, is_colour):
    image = bpy.data.images.new(name, SIZE, SIZE, alpha=False)
    image.colorspace_settings.name = "sRGB" if is_colour else "Non-Color"
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.filepath_raw = os.path.join(folder, name + ".png")
    image.file_format = "PNG"
    image.save()
    return image


def make_material(paint, relief):
    material = bpy.data.materials.new("made")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links

    def texture(image, uv_map):
        node, place = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeUVMap")
        node.image, place.uv_map = image, uv_map
        links.new(place.outputs["UV"], node.inputs["Vector"])
        return node.outputs["Color"]

    shader = nodes["Principled BSDF"]
    links.new(texture(paint, "paint"), shader.inputs["Base Color"])
    bumps = nodes.new("ShaderNodeNormalMap")
    bumps.uv_map = "relief"
    links.new(texture(relief, "relief"), bumps.inputs["Color"])
    links.new(bumps.outputs["Normal"], shader.inputs["Normal"])
    return material


def make(folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh_object = make_mesh()
    rows, columns = np.mgrid[0:SIZE, 0:SIZE]
    paint = np.ones((SIZE, SIZE, 4))
    paint[..., 0] = (columns // 5 + rows // 5) % 2
    paint[..., 1] = columns / SIZE
    paint[..., 2] = (columns * 7 + rows * 13) % 11 / 10
    images = [picture("paint", paint, folder, True),
              picture("relief", bake_normals(mesh_object.data), folder, False)]
    mesh_object.data.materials.append(make_material(*images))
    for name, tangents, kind in [("plain", False, "GLB"), ("tangents", True, "GLB"),
                                 ("plain_parts", False, "GLTF_SEPARATE"),
                                 ("tangents_parts", True, "GLTF_SEPARATE")]:
        os.makedirs(os.path.join(folder, name))
        bpy.ops.export_scene.gltf(filepath=os.path.join(folder, name, name), export_format=kind,
                                  export_tangents=tangents)


def numbers(collection, attribute, width):
    values = np.empty(len(collection) * width, np.float32)
    collection.foreach_get(attribute, values)
    return values


def source(socket, kind):
    """The node of a kind that a socket is fed by, directly or through others."""
    for link in socket.links:
        if link.from_node.bl_idname == kind:
            return link.from_node
        for further in link.from_node.inputs:
            if found := source(further, kind):
                return found
    return None


def texture(shader, socket):
    image = source(shader.inputs[socket], "ShaderNodeTexImage")
    place = image and source(image.inputs["Vector"], "ShaderNodeUVMap")
    pixels = np.empty(len(image.image.pixels) if image else 0, np.float32)
    if image:
        image.image.pixels.foreach_get(pixels)
    return {"uv map": place.uv_map if place else "", "pixels": pixels,
            "size": list(image.image.size) if image else []}


def read(path):
    """What a file holds for Blender: facts by their names, and pictures by their roles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    facts, pictures = {}, {}
    for mesh_object in (o for o in bpy.data.objects if o.type == "MESH"):
        mesh, name = mesh_object.data, mesh_object.name
        mesh.calc_normals_split()
        facts[name + ", its transform"] = np.array(mesh_object.matrix_world)
        facts[name + ", positions"] = numbers(mesh.vertices, "co", 3)
        facts[name + ", corners"] = np.array([loop.vertex_index for loop in mesh.loops])
        facts[name + ", normals"] = numbers(mesh.loops, "normal", 3)
        for layer in mesh.uv_layers:
            facts[name + ", UV set " + layer.name] = numbers(layer.data, "uv", 2)
        for material in mesh.materials:
            shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
            for role, socket in [("base-colour", "Base Color"), ("normal", "Normal")]:
                found = texture(shader, socket)
                facts[role + ", its UV set"] = np.array([found["uv map"]])
                facts[role + ", its size"] = np.array(found["size"])
                pictures[role] = found["pixels"]
    return facts, pictures


def differences(before, after, changed):
    (facts, pictures), (new_facts, new_pictures) = before, read(after)
    wrong = []
    if len(facts) != 10 or any(value.size == 0 for value in facts.values()):
        wrong.append(f"what was exported lacks something: {sorted(facts)}")
    if facts.keys() != new_facts.keys():
        wrong.append(f"{sorted(facts)} became {sorted(new_facts)}")
    wrong += [f"{name} changed" for name in facts.keys() & new_facts.keys()
              if not np.array_equal(facts[name], new_facts[name])]
    for role, pixels in pictures.items():
        same = np.array_equal(pixels, new_pictures[role])
        if same == (role in changed):
            wrong.append(f"the picture {role} " + ("is as it was" if same else "changed"))
    return [f"{os.path.relpath(after)}: {text}" for text in wrong]


def compare(folder):
    os.chdir(folder)
    with open("pairs.json") as file:
        pairs = json.load(file)
    originals = {before: read(before) for before, _, _ in pairs}
    found = [text for before, after, changed in pairs
             for text in differences(originals[before], after, changed)]
    with open("differences.json", "w") as file:
        json.dump(found, file)


if __name__ == "__main__":
    verb, where = sys.argv[sys.argv.index("--") + 1:]
    {"make": make, "compare": compare}[verb](where)
