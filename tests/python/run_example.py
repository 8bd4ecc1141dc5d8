"""run_example.py SCRIPT FOLDER: runs an example, and wants a picture of its name that is not of one colour."""
import pathlib
import runpy
import sys

import numpy as np
from PIL import Image

script, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
picture = folder / (script.stem + ".png")
picture.unlink(missing_ok=True)
sys.argv = [str(script), str(folder)]
runpy.run_path(str(script), run_name="__main__")
pixels = np.asarray(Image.open(picture).convert("RGB"))
assert pixels.std() > 5, f"{picture} shows nothing"
