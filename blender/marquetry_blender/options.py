"""Properties of Blender from the program's option tables, and words for its command line from them.

Nothing of an option is written here: names, ranges, defaults and words are those of the tables."""
import bpy
import numpy as np

from .program import Refusal, read_tables

_packed = read_tables()
VERSION = _packed["version"]
TABLES = _packed["tables"]

#: Files, slots and running: the add-on decides them.
LEFT_OUT = {"output", "report", "config", "json", "quiet", "help", "threads", "seed", "dry-run", "no-clobber",
            "overwrite", "frames", "slot", "uv-set", "layer", "compress", "depth", "vertices", "partial", "confidence",
            "from", "bake"}
#: The same of single verbs: the scene has the photographs, and images their sizes.
LEFT_OUT_OF = {"texture": {"cameras", "images", "size", "unwrap", "picture"}}
#: Shapes, sequences, pictures without a model: other things than textures.
LEFT_OUT_GROUPS = {"Shape", "Pictures", "Sequences", "Evolving meshes", "Running"}
#: Options whose value is a picture.
PICTURES = {"mask", "guide", "labels", "from-mask"}
#: Shown on request.
SELDOM = {"Model", "Solver"}


def rows(verb):
    return [row for row in TABLES[verb]["options"]
            if not row["positional"] and row["name"] not in LEFT_OUT | LEFT_OUT_OF.get(verb, set()) and
            row["group"] not in LEFT_OUT_GROUPS]


def key(row):
    """The name of its property."""
    return row["name"].replace("-", "_")


def label(row):
    return row["name"].replace("-", " ").capitalize()


def description(row):
    text = row["help"][:1].upper() + row["help"][1:] + row["facts"]
    return text + (". " + row["details"].rstrip(".") if row["details"] else "")


def is_number(row):
    """Numbers that always have a value. Others, and lengths, are text, which may be left empty."""
    return row["type"] in ("number", "integer") and (row["default"] or row["required"]) and not row["many"]


def number_property(row, words):
    whole = row["type"] == "integer"
    least, most = row["least"], row["most"]
    limit = 2**31 - 1 if whole else 3.4e38
    low = -limit if least is None else max(-limit, least)
    high = limit if most is None else min(limit, most)
    value = float(row["default"] or low)
    if whole:
        return bpy.props.IntProperty(default=int(value), min=int(low), max=int(high), **words)
    return bpy.props.FloatProperty(default=value, min=low, max=high, precision=4, **words)


def property_of(row, options=frozenset()):
    words = {"name": label(row), "description": description(row), "options": set(options)}
    if row["type"] == "flag":
        return bpy.props.BoolProperty(default=False, **words)
    if row["type"] == "choice":
        items = [(choice, choice.replace("-", " ").capitalize(), "") for choice in row["choices"]]
        return bpy.props.EnumProperty(items=items, default=row["default"] or items[0][0], **words)
    if is_number(row):
        return number_property(row, words)
    return bpy.props.StringProperty(default=row["default"], **words)


def annotations(verb, options=frozenset()):
    """For a class of properties or an operator: fresh properties, since each belongs to one class."""
    return {key(row): property_of(row, options) for row in rows(verb)}


def text_of(row, value):
    """As a user would type it."""
    if row["type"] == "number" and not isinstance(value, str):
        return str(np.float32(value))
    return str(value)


def is_default(row, value):
    if row["required"]:
        return False
    if row["type"] == "flag":
        return not value
    if is_number(row):
        return np.float32(value) == np.float32(row["default"])
    return value == row["default"] or value == ""


def words_of(verb, values, picture_words):
    """The command line for `values`, a function from a row to its value. `picture_words(row, image name)` gives the
    files of an option that is a picture."""
    words = []
    for row in rows(verb):
        value = values(row)
        if is_default(row, value):
            continue
        name = "--" + row["name"]
        if row["type"] == "flag":
            words.append(name)
        elif row["name"] in PICTURES:
            words += picture_words(row, value)
        elif row["type"] == "path":
            raise Refusal(f"{name} is not of the add-on")
        else:
            # One word, so that a value may begin with a hyphen.
            texts = value.split() if row["many"] else [text_of(row, value)]
            words += [f"{name}={text}" for text in texts]
    return words
