"""Types of arguments."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Callable, Iterable, Sequence, Union

if TYPE_CHECKING:
    import numpy as np

#: A file's name.
Path = Union[str, "os.PathLike[str]"]
#: A file's name, a mesh or a picture.
Input = Any
#: A text, or numbers that are one: (0, 0, 1).
Text = Union[str, float, Sequence[float]]
#: Of frames: as the program takes them, "1-100x2", one, (first, last), or whole numbers a step apart.
FrameNumbers = Union[str, int, Iterable[int]]
#: Called with a fraction and the name of a step; True: a bar of tqdm.
Progress = Union[None, bool, Callable[[float, str], None]]
#: Of numbers.
Array = Union["np.ndarray[Any, Any]"]
