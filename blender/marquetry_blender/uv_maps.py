"""New UV maps: corners of triangles onto polygons, which are cut where a seam crosses them."""
import bmesh
import numpy as np


def give(thing, surface, uvs, name):
    """A new active UV map with these values (T, 3, 2); the number of polygons that had to be cut for it."""
    mesh = thing.data
    if mesh.users > 1:
        mesh = thing.data = mesh.copy()
    corners = np.full((len(mesh.loops), 2), np.nan, np.float32)
    corners[surface.loops.ravel()] = uvs.reshape(-1, 2)
    # A corner in several triangles of its polygon has the value of the last of them; where others differ a seam
    # runs through the polygon.
    differ = np.any(corners[surface.loops] != uvs.astype(np.float32), axis=(1, 2))
    crossed = np.unique(surface.polygons[differ])
    layer = mesh.uv_layers.new(name=name, do_init=False)
    layer.data.foreach_set("uv", np.nan_to_num(corners).ravel())
    mesh.uv_layers.active = layer
    if len(crossed):
        _cut(mesh, surface, uvs, set(crossed.tolist()), layer.name)
    return len(crossed)


def _cut(mesh, surface, uvs, crossed, layer_name):
    triangles = {}
    for number in np.flatnonzero(np.isin(surface.polygons, list(crossed))):
        triangles.setdefault(int(surface.polygons[number]), []).append(number)
    edited = bmesh.new()
    try:
        edited.from_mesh(mesh)
        edited.faces.ensure_lookup_table()
        layer = edited.loops.layers.uv[layer_name]
        faces = {polygon: edited.faces[polygon] for polygon in crossed}
        for polygon, numbers in triangles.items():
            values = {frozenset(surface.vertices[n].tolist()): dict(zip(surface.vertices[n].tolist(), uvs[n]))
                      for n in numbers}
            for face in _triangles(faces[polygon], values):
                for loop in face.loops:
                    loop[layer].uv = values[frozenset(v.index for v in face.verts)][loop.vert.index]
        edited.to_mesh(mesh)
    finally:
        edited.free()
    mesh.update()


def _triangles(face, wanted):
    """The face cut along the diagonals of the triangles that are wanted, by sets of their vertices."""
    if frozenset(vertex.index for vertex in face.verts) in wanted:
        return [face]
    around = list(face.verts)
    neighbours = {frozenset((around[i - 1].index, around[i].index)) for i in range(len(around))}
    here = {vertex.index: vertex for vertex in around}
    for triangle in wanted:
        if not triangle <= here.keys():
            continue
        for vertex in triangle:
            ends = triangle - {vertex}
            if ends not in neighbours:
                new, _ = bmesh.utils.face_split(face, *(here[end] for end in ends))
                return _triangles(face, wanted) + _triangles(new, wanted)
    raise AssertionError("triangles of a polygon that do not make it up")
