"""The PEP 517 backend: builds the module by CMake, without CHOLMOD, and packs a wheel with the shared libraries that it
needs beside the C++ runtime. Needs what the project is built from and nothing from the network.

MARQUETRY_WHEEL_BUILD names the build folder (else build/wheel), MARQUETRY_WHEEL_JOBS how many compile at once.
"""
from __future__ import annotations

import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from typing import Any, Optional

SOURCE = pathlib.Path(__file__).resolve().parent.parent
#: What every Linux with this C library has; the interpreter brings the rest of what it needs.
OF_THE_SYSTEM = re.compile(r"^(linux-vdso|ld-linux.*|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+))\.so")
#: Its pictures module stays with the system's OpenImageIO: plain PNG files are read and written without it.
OPTIONAL = "libmarquetry_pictures.so"


def version() -> str:
    text = (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(marquetry VERSION ([0-9.]+)", text)
    assert found is not None
    return found[1]


def tag() -> str:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def build_folder() -> pathlib.Path:
    return pathlib.Path(os.environ.get("MARQUETRY_WHEEL_BUILD", SOURCE / "build" / "wheel"))


def run(*words: Any) -> None:
    subprocess.run([str(word) for word in words], check=True)


def build() -> pathlib.Path:
    """The folder of the package."""
    folder = build_folder()
    run("cmake", "-S", SOURCE, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DMARQUETRY_CHOLMOD=OFF",
        "-DMARQUETRY_VIEWER=OFF", "-DMARQUETRY_TESTS=OFF", "-DMARQUETRY_BENCH=OFF", "-DMARQUETRY_PYTHON=ON",
        f"-DPython3_EXECUTABLE={sys.executable}")
    jobs = os.environ.get("MARQUETRY_WHEEL_JOBS", str(os.cpu_count() or 1))
    run("cmake", "--build", folder, "-j", jobs, "--target", "marquetry_python")
    return folder / "python" / "marquetry"


def libraries_of(module: pathlib.Path) -> dict[str, pathlib.Path]:
    """The shared libraries that it needs, those that they need too, but for the system's own."""
    lines = subprocess.run(["ldd", str(module)], capture_output=True, text=True, check=True).stdout.splitlines()
    found = {}
    for line in lines:
        words = line.split()
        if len(words) >= 3 and words[1] == "=>" and words[2].startswith("/") and not OF_THE_SYSTEM.match(words[0]):
            found[words[0]] = pathlib.Path(words[2])
    return found


def refuse_gpl(libraries: dict[str, pathlib.Path]) -> None:
    """The wheel is under the MIT licence: what is linked with it may not be under the GPL."""
    for name in libraries:
        if re.match(r"lib(cholmod|umfpack|spqr|klu)\.", name):
            raise RuntimeError(f"{name} is under the GPL: the wheel is built without CHOLMOD")


class Wheel:
    """A wheel that is being written: the same files give the same bytes."""

    def __init__(self, path: pathlib.Path) -> None:
        self.archive = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9)
        self.record: list[str] = []

    def add(self, name: str, data: bytes, mode: int = 0o644) -> None:
        info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        info.external_attr = (0o100000 | mode) << 16
        info.compress_type = zipfile.ZIP_DEFLATED
        self.archive.writestr(info, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self, info: str) -> None:
        name = f"{info}/RECORD"
        self.archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)),
                              "\n".join([*self.record, f"{name},,"]) + "\n")
        self.archive.close()


def metadata() -> str:
    return (f"Metadata-Version: 2.1\nName: marquetry\nVersion: {version()}\n"
            "Summary: Signal processing on textured triangle meshes\nLicense: MIT\nRequires-Python: >=3.9\n"
            "Requires-Dist: numpy>=1.21\nRequires-Dist: scipy>=1.7\n")


def stripped(file: pathlib.Path, folder: pathlib.Path) -> bytes:
    """Its bytes without symbols that nothing links with, finding libraries beside it."""
    copy = folder / file.name
    shutil.copyfile(file.resolve(), copy)
    run("strip", "--strip-unneeded", copy)
    if shutil.which("patchelf"):
        run("patchelf", "--set-rpath", "$ORIGIN", copy)
    return copy.read_bytes()


def build_wheel(wheel_directory: str, config_settings: Optional[dict[str, Any]] = None,
                metadata_directory: Optional[str] = None) -> str:
    package = build()
    name = f"marquetry-{version()}-{tag()}.whl"
    info = f"marquetry-{version()}.dist-info"
    (module,) = package.glob("_marquetry*.so")
    libraries = libraries_of(module)
    refuse_gpl(libraries)
    scratch = build_folder() / "stripped"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    wheel = Wheel(pathlib.Path(wheel_directory) / name)
    for file in sorted(package.iterdir()):
        if file.suffix in (".py", ".pyi", ".typed"):
            wheel.add(f"marquetry/{file.name}", file.read_bytes())
    wheel.add(f"marquetry/{module.name}", stripped(module, scratch), 0o755)
    for short, path in sorted(libraries.items()):
        renamed = scratch / short
        shutil.copyfile(path.resolve(), renamed)
        run("strip", "--strip-unneeded", renamed)
        wheel.add(f"marquetry/{short}", renamed.read_bytes(), 0o755)
    pictures = build_folder() / "bin" / OPTIONAL
    wheel.add(f"marquetry/{OPTIONAL}", stripped(pictures, scratch), 0o755)
    wheel.add(f"{info}/METADATA", metadata().encode())
    wheel.add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: marquetry\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode())
    for licence in ("LICENSE", "THIRD_PARTY.md"):
        wheel.add(f"{info}/{licence}", (SOURCE / licence).read_bytes())
    wheel.close(info)
    return name


def build_sdist(sdist_directory: str, config_settings: Optional[dict[str, Any]] = None) -> str:
    raise NotImplementedError("the source is the repository: build a wheel (python3 -m build --wheel)")


def get_requires_for_build_wheel(config_settings: Optional[dict[str, Any]] = None) -> list[str]:
    return []


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: Optional[dict[str, Any]] = None) -> str:
    folder = pathlib.Path(metadata_directory) / f"marquetry-{version()}.dist-info"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "METADATA").write_text(metadata(), encoding="utf-8")
    (folder / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: marquetry\nRoot-Is-Purelib: false\nTag: {tag()}\n",
                                  encoding="utf-8")
    return folder.name
