"""Sequences of meshes in memory, as the numbered files that verbs read."""
from __future__ import annotations

import pathlib
import tempfile
from typing import Any

import numpy as np

from ._errors import InvalidInput
from ._meshes import Mesh, _check_faces, as_mesh, is_mesh, is_path

#: Options that take one.
SEQUENCES = {"sequence", "from_"}


def is_sequence(value: Any) -> bool:
    """A list, a tuple or a generator of meshes."""
    if is_path(value) or is_mesh(value) or hasattr(value, "__array__"):
        return False
    if isinstance(value, (list, tuple)):
        return bool(value) and all(is_mesh(one) for one in value)
    return hasattr(value, "__next__")


class Frames:
    """A temporary folder with a PLY for each mesh, frame_0000.ply and so on, while the object is there."""

    def __init__(self, meshes: Any, name: str) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="marquetry-frames-")
        self.path = self._folder.name
        try:
            if self._write(meshes, name) == 0:
                raise InvalidInput(f"{name}: found no mesh, wanted those of a sequence")
        except BaseException:
            self.close()
            raise

    def _write(self, meshes: Any, name: str) -> int:
        count = 0
        for mesh in meshes:
            where = f"{name}[{count}]"
            write_ply(pathlib.Path(self.path) / f"frame_{count:04d}.ply", as_mesh(mesh, where), where)
            count += 1
        return count

    def close(self) -> None:
        self._folder.cleanup()


def write_ply(path: pathlib.Path, mesh: Mesh, name: str) -> None:
    """Positions as they are, faces, colours at vertices with 8 bits; pictures are files of their own."""
    if mesh.pictures:
        raise InvalidInput(f"{name}: found a picture; frames with pictures are given as files")
    vertices = np.asarray(mesh.vertices, np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise InvalidInput(f"{name}: found vertices of shape {np.shape(mesh.vertices)}, wanted (V, 3) of finite numbers")
    _check_faces(mesh.faces, len(vertices))
    fields: list[Any] = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
    columns = list(vertices.T)
    if mesh.colors is not None:
        colors = np.asarray(mesh.colors)
        if colors.shape not in ((len(vertices), 3), (len(vertices), 4)):
            raise InvalidInput(f"{name}: found colors of shape {colors.shape}, wanted ({len(vertices)}, 3), or 4 with "
                               "alpha, which is left out")
        colors = colors[:, :3]
        most = {"uint8": 255.0, "uint16": 65535.0}.get(str(colors.dtype), 1.0)
        bytes_of_colors = np.clip(np.rint(colors / most * 255), 0, 255)
        fields += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
        columns += list(bytes_of_colors.T)
    rows = np.zeros(len(vertices), fields)
    for (field, _), column in zip(fields, columns):
        rows[field] = column
    faces = np.zeros(len(mesh.faces), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    kinds = {"<f8": "double", "u1": "uchar"}
    properties = "".join(f"property {kinds[kind]} {field}\n" for field, kind in fields)
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{properties}"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(head.encode() + rows.tobytes() + faces.tobytes())
