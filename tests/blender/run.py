#!/usr/bin/env python3
"""run.py BUILD NAME [WORD...]: packs the add-on and runs NAME.py in Blender, with settings of its own: a test, or
`picture FILE`, the picture of docs/blender.md.

Status 77 where Blender, or what else it needs, is not installed."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
#: What runs Blender: a window wants a screen, which Xvfb is.
WINDOW = ["xvfb-run", "-a", "-s", "-screen 0 1280x860x24 +extension GLX", "blender", "--enable-event-simulate",
          "--window-geometry", "0", "0", "1280", "860"]
COMMANDS = {"addon_test": ["blender", "--background"], "window_test": WINDOW, "picture": WINDOW}


def main() -> int:
    build, name = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    for program in (word for word in COMMANDS[name] if word in ("blender", "xvfb-run")):
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed")
            return 77
    with tempfile.TemporaryDirectory() as folder:
        zip_file = os.path.join(folder, "marquetry_blender.zip")
        subprocess.run([sys.executable, HERE.parent.parent / "scripts/blender_addon", build, zip_file], check=True)
        # Debian's Blender looks for its Python along PATH: another one there would have no numpy.
        environment = {**os.environ, "PATH": "/usr/bin:" + os.environ["PATH"],
                       "BLENDER_USER_CONFIG": folder + "/config",
                       "BLENDER_USER_SCRIPTS": folder + "/scripts",
                       "LIBGL_ALWAYS_SOFTWARE": "1", "MARQUETRY_ZIP": zip_file,
                       "MARQUETRY_PROGRAM": str(build / "bin/marquetry"), "PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run([*COMMANDS[name], "--factory-startup", "--python-exit-code", "1", "--python",
                               str(HERE / f"{name}.py"), "--", *sys.argv[3:]], env=environment, check=False)
        return done.returncode


if __name__ == "__main__":
    sys.exit(main())
