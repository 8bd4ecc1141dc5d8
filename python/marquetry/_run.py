"""A verb run in this process: arguments as its options, what it says as warnings and log, what it made."""
from __future__ import annotations

import json
import keyword
import logging
import operator
import os
import re
import warnings
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Iterator

import numpy as np

from . import _marquetry
from ._errors import Error, InvalidInput, Unsupported, Warning
from ._meshes import as_mesh, is_mesh, is_path, joined_arrays
from ._pictures import picture_array
from ._progress import listener
from ._results import Result, result_of
from ._sequences import SEQUENCES, Frames, is_sequence

log = logging.getLogger("marquetry")

#: Results that are files by nature: videos, pages, stores of sequences.
FILES_ALONE = {"track", "evolve", "export", "play", "relight"}
#: Verbs that write nothing where no output is named, and give everything back here.
GIVE_ALL = {"spectrum"}
#: Options of the program that Python has other means for.
LEFT_OUT = {"json", "progress", "quiet", "help", "memory", "scratch"}
PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr", ".bmp", ".tga")
MODELS = (".obj", ".ply", ".gltf", ".glb")


def keyword_of(option: str) -> str:
    """smooth_normals of smooth-normals, from_ of from."""
    name = option.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


@lru_cache(maxsize=None)
def tables() -> dict[str, dict[str, Any]]:
    """The option tables of all verbs, by name."""
    return {table["name"]: table for table in _marquetry.tables()}


def default_of(row: dict[str, Any]) -> Any:
    """An option's default as a value of Python; None: it has none."""
    text = row["default"]
    if row["type"] == "flag":
        return False
    if not text:
        return None
    if row["type"] == "integer":
        return int(text)
    return float(text) if row["type"] == "number" else text


class _Inputs:
    """Inputs held in memory, each under a name of a file.

    names     the options that they were given for, by name
    pictures  what a picture is called that is written beside a model, without extension; empty: as its option
    """

    def __init__(self, pictures: str = "") -> None:
        self.held = _marquetry.Held()
        self.names: dict[str, str] = {}
        self.pictures = pictures
        self.frames: list[Frames] = []

    def close(self) -> None:
        """No frame is needed any more."""
        for frames in self.frames:
            frames.close()

    def _free(self, stem: str, extension: str, option: str) -> str:
        name, number = stem + extension, 1
        while name in self.names:
            number += 1
            name = f"{stem}_{number}{extension}"
        self.names[name] = os.path.splitext(name)[0].replace(stem, option, 1)
        return name

    @contextmanager
    def _named(self, name: str) -> Iterator[None]:
        """What is wrong with an array is said of its option."""
        try:
            yield
        except (Error, TypeError) as error:
            error.args = (str(error).replace(name, self.names[name]),)
            raise

    def take(self, value: Any, option: str) -> tuple[str, list[Any]]:
        """What to name where a file is named, and the pictures that came with it."""
        if is_path(value):
            return _path_text(value, option), []
        if option in SEQUENCES:
            if not is_sequence(value):
                found = "an empty list" if isinstance(value, (list, tuple)) and not value else type(value).__name__
                raise TypeError(f"{option}: found {found}, wanted a path, or a list or generator of meshes")
            self.frames.append(Frames(value, option))
            return self.frames[-1].path, []
        if is_mesh(value):
            mesh = as_mesh(value, option)
            name = self._free(option, ".ply", option)
            with self._named(name):
                self.held.put_model(name, mesh.vertices, mesh.faces, mesh.uvs, mesh.textures, mesh.colors)
            return self.held.path(name), list(mesh.pictures)
        if option == "output" or not any(hasattr(value, has) for has in ("__array__", "__array_interface__", "convert")):
            wanted = "a path" if option == "output" else "a path, a mesh, an array or a picture"
            raise TypeError(f"{option}: found {type(value).__name__}, wanted {wanted}")
        name = self._free(option == "texture" and self.pictures or option, ".png", option)
        with self._named(name):
            self.held.put_picture(name, picture_array(value, option))
        return self.held.path(name), []


def _shown(value: Any) -> str:
    """A value in a message, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _number_text(value: Any, name: str) -> str:
    try:
        return repr(float(value))
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: found {_shown(value)}, wanted a number") from None


def _whole_text(value: Any, name: str) -> str:
    try:
        return str(operator.index(value))
    except (TypeError, ValueError):
        raise TypeError(f"{name}: found {_shown(value)}, wanted a whole number") from None


def _path_text(value: Any, name: str) -> str:
    """A text or a path; names that are not UTF-8 are what os.fsdecode makes of them."""
    text = os.fsdecode(value)
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        raise InvalidInput(f"{name}: found {_shown(text)}, which no file is called by; wanted a text without "
                           "surrogates") from None
    return text


def _frames_text(value: Any, row: dict[str, Any]) -> str:
    """Numbers of frames as the program counts them: of one, of (first, last), of whole numbers a step apart."""
    name = keyword_of(row["name"])
    wanted = "wanted a number, (first, last), or whole numbers a step apart, such as range(1, 101, 2)"
    try:
        numbers = [operator.index(one) for one in (value if hasattr(value, "__iter__") else [value])]
    except TypeError:
        raise TypeError(f"{name}: found {value!r}, {wanted}") from None
    is_pair = isinstance(value, tuple) and len(numbers) == 2
    steps = {1} if is_pair else {after - before for before, after in zip(numbers, numbers[1:])}
    if not numbers or min(numbers) < 0 or len(steps) > 1 or min(steps, default=1) < 1 or numbers[-1] < numbers[0]:
        found = ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "") or "nothing"
        raise InvalidInput(f"{name}: found {found}, {wanted}, from 0 on and increasing")
    if len(numbers) == 1:
        return str(numbers[0])
    step = steps.pop()
    return f"{numbers[0]}-{numbers[-1]}" + (f"x{step}" if step > 1 else "")


def _text(value: Any, row: dict[str, Any]) -> str:
    """A value as a user of the program would type it."""
    kind, name = row["type"], keyword_of(row["name"])
    if isinstance(value, (str, os.PathLike)):
        return _path_text(value, name)
    if row["name"] == "frames" and kind == "text":
        return _frames_text(value, row)
    if kind == "integer":
        return _whole_text(value, name)
    if kind in ("number", "length"):
        return _number_text(value, name)
    if isinstance(value, (tuple, list, np.ndarray)):
        return ",".join(_text(one, row) for one in value)
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: found {value}, wanted a text")
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    raise TypeError(f"{name}: found {type(value).__name__}, wanted a text")


def _several(value: Any, row: dict[str, Any]) -> list[Any]:
    """The values of an option that takes several: a list has one in each place, and an array in each row;
    a tuple of numbers is one."""
    if isinstance(value, list):
        return value
    if row["type"] != "path" and isinstance(value, np.ndarray) and value.ndim == 2:
        return [tuple(one) for one in value]
    if isinstance(value, tuple) and (row["type"] == "path" and not is_mesh(value)
                                     or any(not isinstance(one, (int, float, np.number)) for one in value)):
        return list(value)
    return [value]


def _flat(values: Any) -> list[Any]:
    """Arguments of a place that takes several; lists of pictures stand for what is in them."""
    flat: list[Any] = []
    for value in values:
        is_list = isinstance(value, list) and value and all(
            is_path(one) or (hasattr(one, "__array__") or hasattr(one, "__array_interface__"))
            and getattr(one, "ndim", 2) > 1 for one in value)
        flat.extend(value if is_list else [value])
    return flat


def _stem_of_model(output: Any) -> str:
    """scan of out/scan.obj: two models in one folder each have their pictures. Empty: no model is named."""
    if not is_path(output):
        return ""
    stem, extension = os.path.splitext(os.path.basename(os.fsdecode(output)))
    return stem if extension.lower() in MODELS else ""


class _Words:
    """The options that arguments stand for."""

    def __init__(self, verb: str, output: Any = None) -> None:
        self.verb = verb
        self.rows = {row["name"]: row for row in tables()[verb]["options"]}
        self.inputs = _Inputs(_stem_of_model(output))
        self.given: dict[str, list[str]] = {}

    def add(self, name: str, value: Any) -> None:
        row = self.rows[name]
        if value is None or (row["type"] == "flag" and value is False):
            return
        if row["type"] == "flag":
            if not isinstance(value, (bool, np.bool_)):
                raise TypeError(f"{keyword_of(name)}: found {value!r}, wanted True or False")
            self.given[name] = ["true" if value else "false"]
            return
        values = _several(value, row) if row["many"] else [value]
        if row["type"] != "path":
            self.given[name] = [_text(one, row) for one in values]
            return
        for one in values:
            text, pictures = self.inputs.take(one, keyword_of(name))
            self.given.setdefault(name, []).append(text)
            if pictures and "texture" in self.rows and name != "texture" and not self.given.get("texture"):
                if name == "mesh" and "source" in self.rows:
                    continue  # of the target, which gets others
                self.given["texture"] = [self.inputs.take(picture, "texture")[0] for picture in pictures]

    def add_positional(self, values: list[Any]) -> None:
        places = [row for row in self.rows.values() if row["positional"]]
        for row in places:
            if row["many"]:
                textures = self.given.pop("texture", [])
                if values:
                    self.add(row["name"], values)
                elif textures:
                    self.given[row["name"]] = textures
            elif values:
                self.add(row["name"], values.pop(0))

    def default_output(self) -> None:
        """A place in memory where no output is named."""
        row = self.rows.get("output")
        if row is None or "output" in self.given or not (row["required"] or self.verb in GIVE_ALL):
            return
        if self.verb in FILES_ALONE:
            raise Unsupported(f"output: {self.verb} writes files; name one: {row['help']}")
        if "frames" in self.given:
            raise InvalidInput("output: found none, and with frames there is a file for each: name one with a place "
                               "for the number, such as out_%04d.png")
        self.given["output"] = [self.inputs.held.path(self._output_name(row))]

    def _output_name(self, row: dict[str, Any]) -> str:
        if row["value"] in ("DIR", "FOLDER") or self.verb in {"mask", "fields"}:
            return "out/"
        if row["value"] == "FILE":
            return "out.png"
        input_row = "mesh" if "mesh" in self.given else "template"
        name = self.given.get(input_row, [""])[0].lower()
        if name.endswith(PICTURES):
            return "out/"
        read = [extension for extension in MODELS if name.endswith(extension)]
        own = "" if name.startswith("memory:") or not read else read[0]
        return "out" + (own or ".obj")


def _plain(text: str, words: _Words) -> str:
    """Options as keywords, what is in memory by the name of its argument: there is no file mesh.ply."""
    for name in sorted(words.inputs.names, key=len, reverse=True):
        argument = words.inputs.names[name]
        text = text.replace(words.inputs.held.path(name), argument)
        if not any(os.path.basename(path) == name for paths in words.given.values() for path in paths
                   if path != words.inputs.held.path(name)):
            text = re.sub(r"(?<![\w./-])" + re.escape(name) + r"(?!\w)", argument, text)
    text = text.replace(words.inputs.held.path(""), "")
    for frames in words.inputs.frames:
        text = text.replace(frames.path + "/", "").replace(frames.path, "the sequence")
    for row in words.rows.values():  # the program calls what stands in a place MESH
        if row["positional"]:
            text = re.sub(rf"^({re.escape(row['value'])}|{row['name'].upper()})(?=:| is )", keyword_of(row["name"]), text)

    def keyword(found: re.Match[str]) -> str:
        return keyword_of(found[1]) if found[1] in words.rows else found[0]

    # Commands are shown as they are typed.
    return "\n".join(line if line.lstrip().startswith("marquetry ") else re.sub(r"--([a-z][a-z-]*)", keyword, line)
                     for line in text.split("\n"))


def run(verb: str, arguments: dict[str, Any]) -> Result:
    """Runs the verb with the arguments of its function, by name."""
    words = _Words(verb, arguments.get("output"))
    try:
        with listener(arguments.pop("progress")) as progress:
            return _run_words(verb, arguments, words, progress)
    finally:
        words.inputs.close()


def _run_words(verb: str, arguments: dict[str, Any], words: _Words, progress: Any) -> Result:
    positional: list[Any] = []
    exclusive = {name for group in tables()[verb]["exclusives"] for name in group}
    for name, row in words.rows.items():
        key = keyword_of(name)
        if key not in arguments:
            continue
        value = arguments[key]
        if row["positional"]:
            if value is None and row["required"]:
                raise TypeError(f"{key}: found None, wanted {row['help']}")
            positional.extend(_flat(value) if row["many"] else [value] if value is not None else [])
        elif name in exclusive or not _is_default(value, row):
            words.add(name, value)
    first = next(iter(words.rows))
    words.add_positional(joined_arrays(positional) if first == "mesh" else positional)
    words.default_output()

    def warn(text: str) -> None:
        warnings.warn(_plain(text, words), Warning, stacklevel=5)

    try:
        _, text = _marquetry.run_verb(verb, words.given, progress, lambda said: log.info(_plain(said, words)), warn)
    except (Error, KeyboardInterrupt) as error:
        if error.args:
            error.args = (_plain(str(error), words),)
        raise
    report = json.loads(text.replace(words.inputs.held.path(""), ""))
    in_memory = words.given.get("output", [""])[0].startswith(words.inputs.held.path(""))
    return result_of(report, words.inputs.held, in_memory)


def _is_default(value: Any, row: dict[str, Any]) -> bool:
    default = default_of(row)
    return type(value) is type(default) and bool(value == default)


__all__ = ["run", "tables", "keyword_of", "default_of", "LEFT_OUT", "FILES_ALONE", "InvalidInput"]
