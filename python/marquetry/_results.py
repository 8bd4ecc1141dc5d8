"""What a verb gives back."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Optional

import numpy as np

from ._meshes import Mesh
from ._pictures import Picture, as_picture
from ._types import Array


class Result:
    """What a verb did, and what it made where no output was named.

    report    the program's report: "options", "input", "defects", "result", "solve", "seconds", ...
    files     the files that were written
    pictures  those made, one for each texture, as arrays
    mesh      the model with what changed, where a model was given
    images    all pictures that were made, by name
    fields    vector fields, a vector for each face, by name
    """

    def __init__(self, report: dict[str, Any], files: list[Path], pictures: list[Picture], mesh: Optional[Mesh],
                 images: dict[str, Picture], fields: dict[str, Array]) -> None:
        self.report = report
        self.files = files
        self.pictures = pictures
        self.mesh = mesh
        self.images = images
        self.fields = fields

    @property
    def picture(self) -> Picture:
        """The one picture that was made."""
        if len(self.pictures) != 1:
            raise AttributeError(f"there are {len(self.pictures)} pictures, not one: see pictures and files")
        return self.pictures[0]

    def __array__(self, dtype: Any = None) -> Array:
        return np.asarray(self.picture, dtype)

    def _repr_png_(self) -> Optional[bytes]:
        return self.pictures[0]._repr_png_() if self.pictures else None

    def __repr__(self) -> str:
        parts = [self.report.get("verb", "")]
        if self.files:
            parts.append(f"{len(self.files)} files")
        if self.pictures:
            parts.append(", ".join("x".join(map(str, one.shape)) for one in self.pictures))
        if self.mesh is not None:
            parts.append(repr(self.mesh))
        return f"Result({'; '.join(part for part in parts if part)})"


def result_of(report: dict[str, Any], held: Any, in_memory: bool) -> Result:
    """Of a run, with what it wrote into memory, if that is where its output is."""
    found = report.get("result")
    outputs = list(found.get("outputs", ())) if isinstance(found, dict) else []
    images = {name.split("/", 1)[-1]: as_picture(array) for name, array in held.pictures().items()}
    mesh = None
    names = [name.split("/", 1)[-1] for name in outputs]
    names = [name for name in names if name in images]
    for model in held.models().values():
        names = [name.split("/", 1)[-1] for name in model["pictures"] if name]
        mesh = Mesh(model["vertices"], model["faces"], model["uvs"], model["textures"], model["colors"])
        mesh.pictures = [images[name] for name in names]
        break
    if not names:
        names = list(images)
    files = [] if in_memory else [Path(name) for name in outputs]
    fields = {name.split("/", 1)[-1]: field for name, field in held.fields().items()}
    return Result(report, files, [images[name] for name in names], mesh, images, fields)
