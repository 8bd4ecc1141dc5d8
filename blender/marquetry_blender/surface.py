"""Surfaces of Blender's objects as PLY files, and what comes back in such files."""
import numpy as np

from .program import Refusal

TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4",
         "float": "<f4", "double": "<f8"}


def numbers(collection, attribute, width, kind=np.float32):
    values = np.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, values)
    return values.reshape(-1, width) if width > 1 else values


class Surface:
    """Triangles of a mesh in the axes of the scene: lengths are the scene's, and cameras and the cursor fit.

    positions (V, 3); vertices, loops (T, 3) of Blender's vertices and corners; uvs (T, 3, 2); materials (T);
    normals of corners (T, 3, 3). Of mirrored objects corners 1 and 2 are swapped, so that the outside stays out."""

    def __init__(self, mesh, matrix, uv_name):
        if not mesh.polygons:
            raise Refusal(f"{mesh.name} has no faces")
        layer = mesh.uv_layers.get(uv_name) if uv_name else None
        if hasattr(mesh, "calc_normals_split"):  # gone since 4.1, where corners have normals at any time
            mesh.calc_normals_split()
        mesh.calc_loop_triangles()
        matrix = np.array(matrix)
        self.positions = numbers(mesh.vertices, "co", 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        self.vertices = numbers(mesh.loop_triangles, "vertices", 3, np.int32)
        self.loops = numbers(mesh.loop_triangles, "loops", 3, np.int32)
        self.polygons = numbers(mesh.loop_triangles, "polygon_index", 1, np.int32)
        self.materials = numbers(mesh.polygons, "material_index", 1, np.int32)[self.polygons]
        normals = numbers(mesh.loops, "normal", 3).astype(np.float64)
        if hasattr(mesh, "free_normals_split"):
            mesh.free_normals_split()
        if np.linalg.det(matrix[:3, :3]) < 0:
            for corners in (self.vertices, self.loops):
                corners[:, [1, 2]] = corners[:, [2, 1]]
        across = normals @ np.linalg.pinv(matrix[:3, :3])
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        self.normals = (across / np.where(lengths > 0, lengths, 1))[self.loops]
        self.uvs = numbers(layer.data, "uv", 2)[self.loops] if layer else None

    def write(self, path, pictures=(), picture_of_material=None, with_normals=False):
        """PLY. `pictures` are names of files beside it; `picture_of_material` says which one a material has, -1 for
        none. With normals every corner is a vertex of its own; the program joins them by their places."""
        count = len(self.vertices)
        if with_normals:
            rows = np.empty(3 * count, [("p", "<f8", 3), ("n", "<f4", 3)])
            rows["p"] = self.positions[self.vertices.ravel()]
            rows["n"] = self.normals.reshape(-1, 3)
            corners = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
        else:
            rows = np.empty(len(self.positions), [("p", "<f8", 3)])
            rows["p"] = self.positions
            corners = self.vertices
        columns = [("n", "u1"), ("v", "<i4", 3)]
        columns += [("m", "u1"), ("uv", "<f4", 6)] if self.uvs is not None else []
        columns += [("t", "<i4")] if len(pictures) > 0 else []
        faces = np.empty(count, columns)
        faces["n"], faces["v"] = 3, corners
        if self.uvs is not None:
            faces["m"], faces["uv"] = 6, self.uvs.reshape(-1, 6)
        if len(pictures) > 0:
            table = np.asarray(picture_of_material, np.int32)
            faces["t"] = table[np.clip(self.materials, 0, len(table) - 1)]
        with open(path, "wb") as file:
            file.write(self._header(len(rows), count, pictures, with_normals).encode())
            file.write(rows.tobytes())
            file.write(faces.tobytes())

    def _header(self, vertices, faces, pictures, with_normals):
        lines = ["ply", "format binary_little_endian 1.0"]
        lines += [f"comment TextureFile {name}" for name in pictures]
        lines += [f"element vertex {vertices}"] + [f"property double {axis}" for axis in "xyz"]
        lines += [f"property float n{axis}" for axis in "xyz"] if with_normals else []
        lines += [f"element face {faces}", "property list uchar int vertex_indices"]
        lines += ["property list uchar float texcoord"] if self.uvs is not None else []
        lines += ["property int texnumber"] if len(pictures) > 0 else []
        return "\n".join(lines + ["end_header"]) + "\n"


def read_ply(path):
    """The elements of a binary PLY of triangles as the program writes it: {"vertex": rows, "face": rows}, arrays
    whose columns are the properties."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    elements = []
    for line in data[:end].decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            length = 6 if words[4].startswith("texcoord") else 3
            elements[-1][2].extend([(words[4] + "_count", TYPES[words[2]]), (words[4], TYPES[words[3]], length)])
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[2], TYPES[words[1]]))
    found = {}
    for name, count, columns in elements:
        kind = np.dtype(columns)
        found[name] = np.frombuffer(data, kind, count, end)
        end += count * kind.itemsize
    if end != len(data):
        raise Refusal(f"{path} does not hold triangles as the program writes them")
    return found
