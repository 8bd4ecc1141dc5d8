"""What the tests work on: models as files, made by the program, and as arrays."""
from __future__ import annotations

import atexit
import os
import pathlib
import shutil
import subprocess
import tempfile
from functools import lru_cache
from typing import Any

import numpy as np

import marquetry as mq

PROGRAM = os.environ["MARQUETRY_PROGRAM"]
SOURCE = pathlib.Path(os.environ["MARQUETRY_SOURCE"])


@lru_cache(maxsize=None)
def folder() -> pathlib.Path:
    """A folder for this process, removed at its end."""
    path = pathlib.Path(tempfile.mkdtemp(prefix="marquetry_python_"))
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


def program(*words: Any, cwd: Any = None) -> str:
    """Runs the program; returns what it prints."""
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=cwd, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{words}: {done.returncode}\n{done.stderr}")
    return done.stdout


@lru_cache(maxsize=None)
def sample(name: str = "bust", size: int = 128, triangles: int = 600) -> pathlib.Path:
    """A folder with NAME.obj, NAME.ply and NAME.png."""
    made = folder() / f"{name}_{size}_{triangles}"
    program("sample", name, "-o", f"{made}/", "--size", size, "--triangles", triangles)
    return made


def read_png(path: Any) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(path))


def read_obj(path: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """vertices, faces, uvs of an OBJ of triangles."""
    points, texture, faces, corners = [], [], [], []
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append([float(word) for word in words[1:4]])
        elif words[0] == "vt":
            texture.append([float(word) for word in words[1:3]])
        elif words[0] == "f":
            both = [word.split("/") for word in words[1:]]
            faces.append([int(one[0]) - 1 for one in both])
            corners.append([int(one[1]) - 1 for one in both])
    return np.array(points), np.array(faces, np.int32), np.array(texture)[np.array(corners)]


@lru_cache(maxsize=None)
def arrays(name: str = "bust", size: int = 128, triangles: int = 600) -> tuple[np.ndarray, ...]:
    """vertices, faces, uvs, picture of a sample."""
    made = sample(name, size, triangles)
    return (*read_obj(made / f"{name}.obj"), read_png(made / f"{name}.png"))


def mesh(name: str = "bust", size: int = 128, triangles: int = 600) -> mq.Mesh:
    vertices, faces, uvs, picture = arrays(name, size, triangles)
    return mq.Mesh(vertices, faces, uvs, pictures=[picture])
