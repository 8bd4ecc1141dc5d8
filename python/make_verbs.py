#!/usr/bin/env python3
"""make_verbs.py PACKAGE OUTPUT: the functions of the package, one for each verb, from the program's option tables.

PACKAGE is the folder of the module _marquetry. Names, defaults, ranges, choices and words stand in the tables and
nowhere else."""
import importlib.util
import keyword
import pathlib
import sys
import textwrap
from typing import Any

#: Verbs that are for people in front of a program, or what a script is already.
LEFT_OUT_VERBS = {"batch", "merge", "view"}
LEFT_OUT_OPTIONS = {"json", "progress", "quiet", "help", "memory", "scratch"}
#: Paths that are written to.
OUTPUTS = {"output", "report", "config", "cameras", "plot", "strip", "picture", "record", "screenshot",
           "write-field", "write-potential"}
WIDTH = 110

HEAD = '''"""The verbs of the program as functions. Made by make_verbs.py from its option tables: change those."""
# fmt: off
from __future__ import annotations

from typing import List, Literal, Optional, Union

from ._results import Result
from ._run import run
from ._types import FrameNumbers, Input, Path, Progress, Text
'''


def module_in(package: pathlib.Path) -> Any:
    """_marquetry by itself: the package around it needs what is made here."""
    (found,) = package.glob("_marquetry*.so")
    spec = importlib.util.spec_from_file_location("_marquetry", found)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def keyword_of(option: str) -> str:
    name = option.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def default_of(row: dict) -> str:
    text = row["default"]
    if row["type"] == "flag":
        return "False"
    if not text:
        return "None"
    if row["type"] == "integer":
        return str(int(text))
    return repr(float(text)) if row["type"] == "number" else repr(text)


def type_of(row: dict) -> str:
    kind = row["type"]
    if kind == "path":
        one = "Path" if row["name"] in OUTPUTS else "Input"
    elif row["name"] == "frames" and kind == "text":
        one = "FrameNumbers"
    else:
        one = {"flag": "bool", "integer": "int", "number": "float", "length": "Union[str, float]", "text": "Text",
               "choice": "Literal[" + ", ".join(map(repr, row["choices"])) + "]"}[kind]
    return f"Union[{one}, List[{one}]]" if row["many"] and not row["positional"] else one


def parameters_of(table: dict) -> list:
    exclusive = {name for group in table["exclusives"] for name in group}
    places, required, others = [], [], []
    for row in table["options"]:
        name, kind = keyword_of(row["name"]), type_of(row)
        if row["name"] in LEFT_OUT_OPTIONS:
            continue
        if row["positional"]:
            places.append(f"*{name}: {kind}" if row["many"] else
                          f"{name}: {kind}" if row["required"] else f"{name}: Optional[{kind}] = None")
        elif row["required"] and row["name"] != "output":
            required.append(f"{name}: {kind}")
        else:
            value = "None" if row["name"] in exclusive and row["type"] != "flag" else default_of(row)
            others.append(f"{name}: Optional[{kind}] = None" if value == "None" else f"{name}: {kind} = {value}")
    others.append("progress: Progress = None")
    star = [] if any(place.startswith("*") for place in places) else ["*"]
    return places + star + required + others


def entry_of(row: dict) -> str:
    facts = row["facts"].strip()
    words = row["help"] + (" " + facts if facts else "")
    if row["type"] == "choice" and not row["value"].count("|"):
        words += ": " + ", ".join(row["choices"])
    if row["name"] == "output" and row["required"]:
        words = words.replace(", required", "").replace(" [required]", "") + "; None: what is made is in the result"
    if type_of(row) == "FrameNumbers":
        words += '; "1-100x2", (first, last), or whole numbers a step apart, such as range(1, 101, 2)'
    words += ". " + row["details"] if row["details"] else ""
    return textwrap.fill(f"{keyword_of(row['name'])}: {words}", WIDTH, initial_indent="    ",
                         subsequent_indent="        ", break_on_hyphens=False, break_long_words=False)


def docstring_of(table: dict) -> str:
    lines = [textwrap.fill(table["summary"], WIDTH, initial_indent='    """', subsequent_indent="    "), ""]
    groups: list = []
    rows = [row for row in table["options"] if row["name"] not in LEFT_OUT_OPTIONS]
    for row in rows:
        if row["group"] not in groups:
            groups.append(row["group"])
    for group in groups:
        if group:
            lines += ["", f"    {group}", "    " + "-" * len(group)]
        lines += [entry_of(row) for row in rows if row["group"] == group]
    lines.append(textwrap.fill("progress: called with a fraction and the name of a step; True: a bar of tqdm", WIDTH,
                               initial_indent="    ", subsequent_indent="        "))
    return "\n".join(lines).replace("\\", "\\\\") + '\n    """'


def function_of(table: dict) -> str:
    name = keyword_of(table["name"])
    head = f"def {name}("
    parameters = textwrap.fill(", ".join(parameters_of(table)), WIDTH, initial_indent=head,
                               subsequent_indent=" " * len(head), break_on_hyphens=False, break_long_words=False)
    return f'{parameters}) -> Result:\n{docstring_of(table)}\n    return run("{table["name"]}", locals())\n'


def source_of(tables: list) -> str:
    tables = [table for table in tables if table["name"] not in LEFT_OUT_VERBS]
    names = [keyword_of(table["name"]) for table in tables]
    every = textwrap.fill(", ".join(f'"{name}"' for name in names), WIDTH, initial_indent="__all__ = [",
                          subsequent_indent="           ")
    return HEAD + "\n" + every + "]\n" + "".join("\n\n" + function_of(table) for table in tables)


def main() -> None:
    package, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    text = source_of(module_in(package).tables())
    if not output.exists() or output.read_text(encoding="utf-8") != text:
        output.write_text(text, encoding="utf-8")
    output.touch()


if __name__ == "__main__":
    main()
