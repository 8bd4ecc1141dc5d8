"""What of Blender's data a verb works on: the active object, its UV map, its pictures."""
import numpy as np

from . import pictures
from .program import Refusal
from .surface import Surface


class NoImages(Refusal):
    """None of the materials has an image."""


def active_object(context):
    thing = context.active_object
    if thing is None or thing.type != "MESH":
        raise Refusal("no mesh is active: click on one")
    if thing.mode == "EDIT":
        raise Refusal(f"{thing.name} is in edit mode: leave it first (Tab)")
    return thing


def active_uv_map(thing):
    layer = thing.data.uv_layers.active
    if layer is None:
        raise Refusal(f"{thing.name} has no UV map: unwrap it first, with Unwrap of Marquetry or Blender's own (U)")
    return layer.name


def surface_of(context, thing, uv_name, modifiers):
    """As it is seen, with modifiers, or the mesh itself, to which results can be given."""
    if not modifiers:
        return Surface(thing.data, thing.matrix_world, uv_name), thing.material_slots
    depsgraph = context.evaluated_depsgraph_get()
    seen = thing.evaluated_get(depsgraph)
    mesh = seen.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        surface = Surface(mesh, seen.matrix_world, uv_name)
    finally:
        seen.to_mesh_clear()
    if uv_name and surface.uvs is None:
        raise Refusal(f"the modifiers of {thing.name} leave no UV map {uv_name}: turn Modifiers off")
    return surface, seen.material_slots


def image_nodes(material):
    if material is None or not material.use_nodes:
        return []
    return [node for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image]


def image_of(material):
    """That of the active image node, as for Blender's own baking; else the base colour's; else the only one."""
    nodes = image_nodes(material)
    if not nodes:
        return None
    active = material.node_tree.nodes.active
    if active in nodes:
        return active.image
    for shader in material.node_tree.nodes:
        if shader.type == "BSDF_PRINCIPLED":
            for link in shader.inputs["Base Color"].links:
                if link.from_node in nodes:
                    return link.from_node.image
    images = {node.image for node in nodes}
    if len(images) > 1:
        raise Refusal(f"material {material.name} has {len(images)} images, none of them its base colour: "
                      "make the node of one active, or use the panel of the Image editor")
    return images.pop()


def images_of(thing, slots, only):
    """Images, and for each material slot the number of its own, -1 where it has none. `only`: this one, on the
    triangles whose materials have it, or on all where none has."""
    materials = [slot.material.original if slot.material else None for slot in slots] or [None]
    if only is not None:
        has = [any(node.image == only for node in image_nodes(material)) for material in materials]
        return [only], [0 if it or not any(has) else -1 for it in has]
    images, table = [], []
    for material in materials:
        image = image_of(material)
        if image is not None and image not in images:
            images.append(image)
        table.append(-1 if image is None else images.index(image))
    if not images:
        raise NoImages(f"no material of {thing.name} has an image: add an Image Texture node, "
                       "or use the panel of the Image editor")
    return images, table


def corner_values(surface, faces, thing):
    """Texture coordinates (T, 3, 2) of a PLY's faces that are the surface's own triangles."""
    if len(faces) != len(surface.vertices) or not np.array_equal(faces["vertex_indices"], surface.vertices):
        raise Refusal(f"the program gave {len(faces)} triangles for the {len(surface.vertices)} of {thing.name}, "
                      "or others: clean the mesh up first (Mesh > Clean Up)")
    return faces["texcoord"].reshape(-1, 3, 2)


def save_pictures(images, folder):
    saved = [pictures.Picture(image, f"picture{number}") for number, image in enumerate(images)]
    for picture in saved:
        picture.save(folder)
    return saved
