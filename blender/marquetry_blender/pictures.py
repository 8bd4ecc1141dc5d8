"""Image datablocks as files for the program, and its files as pixels of datablocks.

What is processed is what Blender holds: unsaved painting, packed and generated pictures too. Pictures of bytes go
as PNG, in the encoding that they have; pictures of floats as EXR, in scene linear light, 32 bits."""
import filecmp
import glob
import os
import re
import struct
import zlib

import bpy
import numpy as np

from .program import Refusal


def write_png(path, values):
    """(H, W, 1, 3 or 4) of uint8, row 0 on top."""
    height, width, channels = values.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    lines = np.zeros((height, 1 + width * channels), np.uint8)
    lines[:, 1:] = values.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 1)) +
                   chunk(b"IEND", b""))


def write_exr(path, values):
    """(H, W, 1, 3 or 4) of float32, row 0 on top: scan lines without compression."""
    height, width, channels = values.shape
    names = {1: "Y", 3: "RGB", 4: "RGBA"}[channels]
    order = sorted(range(channels), key=lambda c: names[c])

    def attribute(name, kind, data):
        return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data

    listed = b"".join(names[c].encode() + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for c in order) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<Ii", 0x01312F76, 2) + attribute("channels", "chlist", listed)
    head += attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    head += attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    lines = np.empty(height, [("y", "<i4"), ("size", "<i4"), ("values", "<f4", (channels, width))])
    lines["y"], lines["size"] = np.arange(height), 4 * channels * width
    lines["values"] = values[:, :, order].transpose(0, 2, 1)
    offsets = len(head) + 8 * height + lines.itemsize * np.arange(height, dtype="<u8")
    with open(path, "wb") as file:
        file.write(head + offsets.astype("<u8").tobytes() + lines.tobytes())


def pixels_of(image):
    """(H, W, channels) of float32, row 0 below, as Blender has it."""
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, image.channels)


def set_pixels(image, values):
    image.pixels.foreach_set(np.ascontiguousarray(values, np.float32).ravel())
    image.update()


def pixels_of_file(path):
    """A file's values as they are stored."""
    loaded = bpy.data.images.load(path)
    try:
        loaded.colorspace_settings.is_data = True
        if not loaded.size[0]:
            raise Refusal(f"{path} cannot be read by Blender")
        return pixels_of(loaded)
    finally:
        bpy.data.images.remove(loaded)


def push_undo(image):
    """A step of Blender's undo for pictures that holds the pixels as they are: nothing is inverted. Python has no
    other way to that undo. Without a window there is none, and Blender would crash."""
    if bpy.app.background:
        return
    with bpy.context.temp_override(edit_image=image):
        bpy.ops.image.invert("EXEC_DEFAULT", invert_r=False, invert_g=False, invert_b=False, invert_a=False)


def with_names_of_images(text, names):
    """What the program says of files, said of datablocks: `names` has those by the files' stems."""
    return re.sub(r"(?:out/)?\b([a-z-]+\d*)((?:\.\d{4})?)\.(?:png|exr)\b",
                  lambda found: names[found[1]] + found[2] if found[1] in names else found[0], text)


def check(image):
    """Refuses what cannot be processed or would not be kept."""
    if image.source not in {"FILE", "GENERATED", "TILED"}:
        raise Refusal(f"image {image.name} is a {image.source.lower()}: single pictures and UDIM tiles are processed")
    if image.library:
        raise Refusal(f"image {image.name} is linked from {image.library.filepath}: make it local first "
                      "(ID Data > Make Local)")
    if not image.size[0] or not image.size[1]:
        raise Refusal(f"image {image.name} has no pixels: its file {image.filepath or 'is not set'}"
                      f"{' is missing' if image.filepath else ''}; choose a file, or make a new image")


class Picture:
    """A datablock and its file in the folder of a run."""

    def __init__(self, image, stem):
        check(image)
        self.name, self.stem = image.name, stem
        self.tiled = image.source == "TILED"
        self.is_float = image.is_float
        self.ending = ".exr" if self.is_float else ".png"
        self.channels, self.print = 0, None  # of pixels that are no tiles

    @property
    def image(self):
        return bpy.data.images.get(self.name)

    @property
    def file(self):
        """As PLY and the command line name it."""
        return self.stem + (".<UDIM>" if self.tiled else "") + self.ending

    def save(self, folder):
        """The files that were written."""
        return self._save_tiles(folder) if self.tiled else self._save_pixels(os.path.join(folder, self.file))

    def _save_tiles(self, folder):
        """Blender saves all tiles, painted or packed, and leaves the datablock as it is."""
        try:
            with bpy.context.temp_override(edit_image=self.image):
                bpy.ops.image.save_as("EXEC_DEFAULT", filepath=os.path.join(folder, self.file), copy=True,
                                      save_as_render=False)
        except RuntimeError as error:
            raise Refusal(f"Blender cannot save the tiles of image {self.name}: {error}") from error
        written = glob.glob(os.path.join(glob.escape(folder), self.stem + ".1*"))
        if not written:
            raise Refusal(f"Blender wrote no tile of image {self.name}: save it, or fill its tiles")
        self.ending = os.path.splitext(written[0])[1]
        return written

    def _save_pixels(self, path):
        image = self.image
        values = pixels_of(image)
        self.print = zlib.crc32(values)
        self.channels = self._channels(image, values)
        values = values[::-1, :, :self.channels]
        if self.is_float:
            write_exr(path, values)
        else:
            write_png(path, np.rint(values * 255).astype(np.uint8))
        return [path]

    def _channels(self, image, values):
        """How many are processed: alpha that means nothing, or is one everywhere, is left alone."""
        count = values.shape[2]
        if count < 3:
            return 1
        grey = image.depth == 8 and np.array_equal(values[..., 0], values[..., 1]) and \
            np.array_equal(values[..., 0], values[..., 2])
        alone = {"NONE", "CHANNEL_PACKED"} if self.is_float else {"NONE"}
        if count == 3 or image.alpha_mode in alone or np.all(values[..., 3] == 1):
            return 1 if grey else 3
        return 4

    def put(self, folder, message):
        """The result into the datablock; pairs of a level and a text that the user should know. A datablock that
        changed meanwhile keeps its pixels."""
        image = self.image
        if image is None:
            return [("WARNING", f"image {self.name} is gone, and so is what was made of it")]
        if self.tiled:
            return self._put_tiles(image, folder, message)
        new = pixels_of_file(os.path.join(folder, self.file))
        if image.size[0] == 0 or zlib.crc32(pixels_of(image)) != self.print:
            other = new_image(f"{self.name} {message}", new, self.is_float)
            return [("WARNING", f"image {self.name} was changed meanwhile: the result is in {other.name}")]
        values = pixels_of(image)
        colours = min(values.shape[2], 3)
        values[..., :colours] = new[..., :colours] if self.channels > 1 else new[..., :1]
        if self.channels == 4:
            values[..., 3] = new[..., 3]
        push_undo(image)
        set_pixels(image, values)
        push_undo(image)
        return []

    def _put_tiles(self, image, folder, message):
        """Packed, since Python cannot write the pixels of tiles; what was there is packed in another datablock."""
        now = os.path.join(folder, "now")
        os.mkdir(now)
        if not all(filecmp.cmp(path, os.path.join(os.path.dirname(folder), os.path.basename(path)), False)
                   for path in self._save_tiles(now)):
            result = image.copy()
            result.name = f"{self.name} {message}"
            result.use_fake_user = True
            self._pack(result, folder)
            return [("WARNING", f"image {self.name} was changed meanwhile: the result is in {result.name}")]
        before = image.copy()
        before.name = f"{self.name} before"
        before.use_fake_user = True
        self._pack(before, os.path.dirname(folder))
        self._pack(image, folder)
        return [("INFO", f"tiles of {self.name} are packed; as they were they are in {before.name}")]

    def _pack(self, image, folder):
        path = image.filepath_raw
        image.filepath_raw = os.path.join(folder, self.file)
        image.reload()
        image.pack()
        image.filepath_raw = path


def new_image(name, values, is_float, is_data=False):
    """A new datablock with these pixels, packed and kept so that it is saved with the file."""
    height, width, channels = values.shape
    image = bpy.data.images.new(name, width, height, alpha=channels == 4, float_buffer=is_float, is_data=is_data)
    full = np.ones((height, width, image.channels), np.float32)
    full[..., :min(channels, 4)] = values[..., :4]
    set_pixels(image, full)
    image.pack()
    image.use_fake_user = True
    return image
