"""Small objects with known texture coordinates, and the program called by hand on files of them."""
import os
import subprocess

import bpy
import numpy as np

PROGRAM = os.environ["MARQUETRY_PROGRAM"]


def install():
    """The add-on as a user installs it: from its zip."""
    bpy.ops.preferences.addon_install(filepath=os.environ["MARQUETRY_ZIP"])
    bpy.ops.preferences.addon_enable(module="marquetry_blender")
    preferences().program = PROGRAM


def preferences():
    return bpy.context.preferences.addons["marquetry_blender"].preferences


def empty_scene():
    for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.images, bpy.data.cameras):
        for each in list(kind):
            if each.name != "Render Result":
                kind.remove(each)


def cube(parts=3, cells=None):
    """A cube of side 2, 6 · parts² quads; side k is a chart in cell `cells[k]` of quarters of the texture's sides.
    All numbers have few binary digits, so that files of text hold them exactly."""
    cells = cells or [(0, 0), (1.25, 0), (2.5, 0), (0, 1.25), (1.25, 1.25), (2.5, 1.25)]
    steps = np.round(np.linspace(0, 1, parts + 1) * 64) / 64
    places, points, faces, uvs, sides = {}, [], [], [], []
    for side in range(6):
        axis, high = side % 3, side // 3

        def point(i, j):
            xyz = np.empty(3)
            xyz[axis] = 2 * high - 1
            xyz[(axis + 1) % 3], xyz[(axis + 2) % 3] = 2 * steps[i] - 1, 2 * steps[j] - 1
            return places.setdefault(tuple(xyz), len(places))

        for i in range(parts):
            for j in range(parts):
                corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                corners = corners if high else corners[::-1]
                faces.append([point(*c) for c in corners])
                uvs += [((cells[side][0] + 0.125 + steps[a]) / 4, (cells[side][1] + 0.125 + steps[b]) / 4)
                        for a, b in corners]
                sides.append(side)
    points = list(places)
    mesh = bpy.data.meshes.new("cube")
    mesh.from_pydata(points, [], faces)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array(uvs, np.float32).ravel())
    thing = bpy.data.objects.new("cube", mesh)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    return thing, np.array(sides)


def image(name="paint", size=64, seed=1, is_float=False):
    made = bpy.data.images.new(name, size, size, alpha=False, float_buffer=is_float, is_data=is_float)
    values = np.random.default_rng(seed).integers(60, 200, (size, size, 4)) / 255
    values[..., 3] = 1
    made.pixels.foreach_set(values.astype(np.float32).ravel())
    return made


def material(thing, picture):
    made = bpy.data.materials.new("material")
    made.use_nodes = True
    if picture is not None:
        node = made.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = picture
        shader = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        made.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    thing.data.materials.append(made)


def painted_cube(**words):
    thing, _ = cube()
    picture = image(**words)
    material(thing, picture)
    return thing, picture


def cube_with_tiles():
    """A cube of three materials, its plain image, and that of two tiles."""
    # Sides 4 and 5 in the second tile; side 2 has no picture.
    thing, sides = cube(cells=[(0, 0), (1.25, 0), (0, 0), (2.5, 2.5), (4, 1.25), (6, 1.25)])
    plain, tiled = image("plain"), bpy.data.images.new("tiled", 64, 64, tiled=True, alpha=False)
    tiled.tiles.active = tiled.tiles.new(1002)
    with bpy.context.temp_override(edit_image=tiled):
        bpy.ops.image.tile_fill(color=(1, 0.5, 0, 1), generated_type="COLOR_GRID", width=32, height=32,
                                alpha=False)
    tiled.pixels.foreach_set(pixels(image("noise", seed=2)).ravel())  # the first: not saved
    for picture in (plain, tiled, None):
        material(thing, picture)
    thing.data.polygons.foreach_set("material_index", np.array([0, 0, 2, 1, 1, 1])[sides].astype(np.int32))
    return thing, plain, tiled


def pixels(picture):
    values = np.empty(len(picture.pixels), np.float32)
    picture.pixels.foreach_get(values)
    return values.reshape(picture.size[1], picture.size[0], -1)


def save_copy(picture, path):
    """By Blender itself: the picture that a user would give to the program."""
    with bpy.context.temp_override(edit_image=picture):
        bpy.ops.image.save_as(filepath=path, copy=True, save_as_render=False)


def read(path):
    loaded = bpy.data.images.load(path)
    loaded.colorspace_settings.is_data = True
    return pixels(loaded)


def write_obj(thing, path, pictures, with_normals=False):
    """`pictures`: a file for each material, or None."""
    mesh = thing.data
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
    mesh.calc_loop_triangles()
    with open(os.path.splitext(path)[0] + ".mtl", "w", encoding="utf-8") as file:
        for number, picture in enumerate(pictures):
            file.write(f"newmtl m{number}\n" + (f"map_Kd {picture}\n" if picture else ""))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"mtllib {os.path.basename(os.path.splitext(path)[0])}.mtl\n")
        file.writelines("v %r %r %r\n" % tuple(thing.matrix_world @ vertex.co) for vertex in mesh.vertices)
        file.writelines("vt %r %r\n" % tuple(corner.uv) for corner in mesh.uv_layers.active.data)
        if with_normals:
            file.writelines("vn %r %r %r\n" % tuple(loop.normal) for loop in mesh.loops)
        for triangle in mesh.loop_triangles:
            file.write(f"usemtl m{triangle.material_index}\nf " + " ".join(
                f"{v + 1}/{l + 1}" + (f"/{l + 1}" if with_normals else "")
                for v, l in zip(triangle.vertices, triangle.loops)) + "\n")


def program(folder, *words):
    done = subprocess.run([PROGRAM, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done
