"""Meshes: arrays with names, and what is taken for one."""
from __future__ import annotations

import os
from typing import Any, Optional, Sequence

import numpy as np

from ._arrays import plain_array
from ._errors import InvalidInput
from ._pictures import Picture, as_picture, picture_array
from ._types import Array


class Mesh:
    """A triangle mesh whose texture coordinates belong to the corners of its faces.

    vertices  (V, 3) floats
    faces     (F, 3) whole numbers: the vertices of each face, counter-clockwise seen from outside
    uvs       (F, 3, 2) floats, (0, 0) bottom left, NaN where a corner has none; (V, 2) where each vertex has one
    textures  (F,) whole numbers: which of the pictures a face shows, -1 for none; None: all show the first
    colors    (V, 1 to 4) of uint8, uint16 or float32: values at vertices
    pictures  the textures
    """

    def __init__(self, vertices: Any, faces: Any, uvs: Any = None, textures: Any = None, colors: Any = None,
                 pictures: Any = ()) -> None:
        for name, value in (("vertices", vertices), ("faces", faces)):
            if value is None:
                raise TypeError(f"{name}: found None, wanted an array")
        self.vertices = plain_array(vertices, "vertices")
        self.faces = plain_array(faces, "faces")
        self.uvs: Optional[Array] = None if uvs is None else plain_array(uvs, "uvs")
        self.textures: Optional[Array] = None if textures is None else plain_array(textures, "textures")
        self.colors: Optional[Array] = None if colors is None else _single(plain_array(colors, "colors"))
        given = list(pictures) if isinstance(pictures, (list, tuple)) else [pictures]
        self.pictures: list[Picture] = [as_picture(picture_array(one, "pictures")) for one in given]
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise InvalidInput(f"vertices: found an array of shape {self.vertices.shape}, wanted (vertices, 3)")
        _check_kind_of_faces(self.faces)
        if self.uvs is not None and self.uvs.ndim == 2:
            self.uvs = _corner_uvs(self.uvs, self.faces, len(self.vertices))

    def __repr__(self) -> str:
        parts = [f"{len(self.vertices)} vertices", f"{len(self.faces)} faces"]
        if self.uvs is not None:
            parts.append("uvs")
        if self.colors is not None:
            parts.append("colors")
        if self.pictures:
            parts.append(f"{len(self.pictures)} picture" + "s" * (len(self.pictures) > 1))
        return f"Mesh({', '.join(parts)})"


def _single(values: Array) -> Array:
    """Floats as float32, others as they are."""
    return values.astype(np.float32) if values.dtype.kind == "f" and values.dtype != np.float32 else values


def _corner_uvs(uvs: Array, faces: Array, vertices: int) -> Array:
    """Those of the faces' corners where each vertex has one."""
    if uvs.shape != (vertices, 2):
        raise InvalidInput(f"uvs: found an array of shape {uvs.shape}, wanted ({len(faces)}, 3, 2) or "
                           f"({vertices}, 2)")
    _check_faces(faces, vertices)
    return np.asarray(uvs[faces])


def _check_kind_of_faces(faces: Array) -> None:
    if faces.ndim != 2 or faces.shape[1] != 3:
        hint = ": make two triangles of each" if faces.ndim == 2 and faces.shape[1] == 4 else ""
        raise InvalidInput(f"faces: found an array of shape {faces.shape}, wanted (faces, 3){hint}")
    if faces.dtype.kind not in "iu":
        raise TypeError(f"faces: found an array of {faces.dtype}, wanted whole numbers, such as int32")


def _check_faces(faces: Array, vertices: int) -> None:
    _check_kind_of_faces(faces)
    if faces.size and (faces.min() < 0 or faces.max() >= vertices):
        raise InvalidInput(f"faces: found {faces.min()} to {faces.max()}, wanted 0 to {vertices - 1}")


def is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def is_mesh(value: Any) -> bool:
    """A `Mesh`, a pair or triple of arrays, or an object with vertices and faces (trimesh) or triangles (open3d)."""
    if isinstance(value, Mesh):
        return True
    if isinstance(value, (tuple, list)):
        return 2 <= len(value) <= 3 and all(hasattr(one, "__array__") or isinstance(one, list) for one in value)
    return hasattr(value, "vertices") and (hasattr(value, "faces") or hasattr(value, "triangles"))


def as_mesh(value: Any, name: str = "mesh") -> Mesh:
    """The mesh that the value is taken for."""
    if isinstance(value, Mesh):
        return value
    if isinstance(value, (tuple, list)) and is_mesh(value):
        return Mesh(*value)
    if not is_mesh(value):
        raise TypeError(f"{name}: found {type(value).__name__}, wanted a Mesh, (vertices, faces), "
                        "(vertices, faces, uvs) or an object that has vertices and faces")
    if hasattr(value, "faces"):
        return _of_trimesh(value)
    return _of_open3d(value)


def _of_trimesh(value: Any) -> Mesh:
    """vertices, faces; visual.uv at vertices; visual.material with image or baseColorTexture; visual.vertex_colors
    where it says that its kind is these."""
    visual = getattr(value, "visual", None)
    uvs = getattr(value, "uvs", None)
    if uvs is None:
        uvs = getattr(visual, "uv", None)
    material = getattr(visual, "material", None)
    image = getattr(material, "image", None)
    if image is None:
        image = getattr(material, "baseColorTexture", None)
    # Where none were given, trimesh makes up grey ones.
    colors = getattr(visual, "vertex_colors", None) if getattr(visual, "kind", None) == "vertex" else None
    if colors is not None:
        colors = np.asarray(colors)
        if colors.ndim == 2 and colors.shape[1] == 4 and colors.dtype == np.uint8 and (colors[:, 3] == 255).all():
            colors = colors[:, :3]  # trimesh adds an alpha that says nothing
    return Mesh(value.vertices, value.faces, uvs, colors=colors, pictures=() if image is None else (image,))


def _of_open3d(value: Any) -> Mesh:
    """vertices, triangles; triangle_uvs, three for each triangle one after the other; textures, their rows from
    below; vertex_colors."""
    faces = np.asarray(value.triangles)
    corners = np.asarray(getattr(value, "triangle_uvs", ()))
    uvs = corners.reshape(-1, 3, 2) if corners.size == 6 * len(faces) and corners.size else None
    colors = np.asarray(getattr(value, "vertex_colors", ()))
    pictures = [np.asarray(one)[::-1] for one in getattr(value, "textures", ()) if np.asarray(one).size]
    textures = np.asarray(getattr(value, "triangle_material_ids", ()))
    return Mesh(value.vertices, faces, uvs,
                textures=textures if len(pictures) > 1 and len(textures) == len(faces) else None,
                colors=colors.astype(np.float32) if colors.size else None, pictures=pictures if uvs is not None else ())


def joined_arrays(arguments: Sequence[Any]) -> list[Any]:
    """Arguments that begin with vertices, faces and perhaps uvs, with these as one mesh."""
    given = list(arguments)
    if len(given) < 2 or any(is_path(one) or is_mesh(one) for one in given[:2]):
        return given
    first, second = np.asarray(given[0]), np.asarray(given[1])
    # No picture is as narrow as that.
    if not (first.ndim == second.ndim == 2 and first.shape[1] in (2, 3) and second.shape[1] in (3, 4)
            and first.dtype.kind in "iuf" and second.dtype.kind in "iuf"):
        return given
    uvs, rest = None, given[2:]
    if rest and not is_path(rest[0]) and not is_mesh(rest[0]):
        third = np.asarray(rest[0])
        if third.dtype.kind == "f" and (third.shape == (len(second), 3, 2) or third.shape == (len(first), 2)):
            uvs, rest = rest[0], rest[1:]
    return [Mesh(given[0], given[1], uvs), *rest]
