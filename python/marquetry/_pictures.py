"""Pictures: arrays that a notebook shows, and what is taken for one."""
from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np

from ._arrays import plain_array
from ._errors import InvalidInput
from ._types import Array


class Picture(np.ndarray[Any, Any]):
    """An array (height, width) or (height, width, channels), row 0 on top, that a notebook shows.

    Of uint8 or uint16 as a file has them, or of floats with 1 for white.
    """

    def __array_wrap__(self, out: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """What is computed of a picture is an array or a number, and no picture."""
        return np.asarray(out)[()] if np.ndim(out) == 0 else np.asarray(out)

    def _repr_png_(self) -> bytes | None:
        return png_bytes(self) if self.ndim in (2, 3) and self.size else None

    def save(self, path: Any) -> None:
        """Writes it as a PNG: 8 or 16 bits as it has them, floats with 8."""
        with open(path, "wb") as file:
            file.write(png_bytes(self))


def as_picture(array: Any) -> Picture:
    """The array as a `Picture`, not copied."""
    return np.asarray(array).view(Picture)


def png_bytes(array: Any) -> bytes:
    """A PNG of the array; of two channels the first, as PNG viewers know no other pairs than grey with alpha."""
    values = np.asarray(array)
    if values.ndim == 2:
        values = values[:, :, None]
    if values.ndim != 3 or values.shape[2] not in (1, 2, 3, 4) or not values.size:
        raise InvalidInput(f"a picture to show: found an array of shape {np.shape(array)}, "
                           "wanted (height, width) or (height, width, 1 to 4)")
    if values.dtype == np.uint16:
        values, bits = values.astype(">u2"), 16
    elif values.dtype == np.uint8:
        bits = 8
    else:
        shown = np.nan_to_num(values.astype(np.float64), posinf=1.0, neginf=0.0)
        values, bits = (np.clip(shown, 0, 1) * 255 + 0.5).astype(np.uint8), 8
    height, width, channels = values.shape
    rows = np.ascontiguousarray(values).reshape(height, -1).view(np.uint8)
    lines = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1)
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 6))
            + chunk(b"IEND", b""))


def _of_pil(image: Any) -> Any:
    """A picture of PIL whose values are not what they look like as an array: palettes, single bits, colours that are
    multiplied by alpha, a channel that is none."""
    mode = image.mode
    if mode == "P":
        return image.convert("RGBA" if "transparency" in image.info else "RGB")
    others = {"1": "L", "PA": "RGBA", "La": "LA", "RGBa": "RGBA", "RGBX": "RGB"}
    if mode in others:
        return image.convert(others[mode])
    if mode in ("CMYK", "YCbCr", "LAB", "HSV"):
        raise InvalidInput(f"a picture of mode {mode}: convert it to RGB first")
    return image


def _conversion(array: Array) -> str:
    """What makes a picture of other whole numbers. None is guessed: 200 is another grey of 8 bits than of 16."""
    if array.dtype.kind not in "iu" or not array.size or array.min() < 0 or array.max() > 65535:
        return ""
    if array.max() > 255:
        return "; .astype(np.uint16) makes one of it"
    return "; .astype(np.uint8) makes one of it, or .astype(np.uint16) where white is 65535"


def picture_array(value: Any, name: str) -> Array:
    """What can be taken for a picture: arrays, and whatever has an array interface. Not copied where its values
    are uint8, uint16 or float32; other floats become float32."""
    if hasattr(value, "mode") and hasattr(value, "convert"):
        value = _of_pil(value)
    if not (isinstance(value, np.ndarray) or hasattr(value, "__array_interface__") or hasattr(value, "__array__")):
        raise TypeError(f"{name}: found {type(value).__name__}, wanted a path, an array or a picture")
    array = plain_array(value, name)
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[:, :, 0]
    if array.dtype.kind == "f" and array.dtype != np.float32:
        array = array.astype(np.float32)
    elif array.dtype == np.int32 and getattr(value, "mode", "") == "I":
        if array.size and (array.min() < 0 or array.max() > 65535):
            raise InvalidInput(f"{name}: a picture of mode I with values outside 0 to 65535")
        array = array.astype(np.uint16)
    elif not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    elif array.dtype == np.bool_:  # a mask
        array = array.astype(np.uint8) * np.uint8(255)
    if array.dtype.type not in (np.uint8, np.uint16, np.float32):
        raise TypeError(f"{name}: found an array of {array.dtype}, wanted uint8 (0 to 255), uint16 (0 to 65535) or "
                        "floats (0 to 1)" + _conversion(array))
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0][:2]
        raise InvalidInput(f"{name}: found {array[row, column]} at row {row}, column {column}, wanted finite values")
    return array
