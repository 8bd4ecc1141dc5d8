"""Cameras of the scene with their photographs, as `texture --cameras` reads them."""
import json
import os

import numpy as np

from . import pictures
from .program import Refusal


def photograph_of(camera):
    """The first background image that is a picture, or None."""
    for background in camera.data.background_images:
        if background.source == "IMAGE" and background.image:
            return background.image
    return None


def with_photographs(scene):
    return [thing for thing in scene.objects if thing.type == "CAMERA" and photograph_of(thing)]


def entry_of(camera, depsgraph, width, height, file):
    """Intrinsics for a photograph of that size: lens, shift and sensor fit are in Blender's own projection."""
    if camera.data.type != "PERSP":
        raise Refusal(f"camera {camera.name} is {camera.data.type.lower()}: perspective ones are taken")
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=width, y=height))
    matrix = np.array(camera.evaluated_get(depsgraph).matrix_world)
    # Blender looks along -z with y up, the program along z with y down; a camera's scale means nothing.
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    rotation = np.diag([1, -1, -1]) @ axes.T
    return {"image": file, "width": width, "height": height,
            "fx": projection[0, 0] * width / 2, "fy": projection[1, 1] * height / 2,
            "cx": (1 - projection[0, 2]) * width / 2, "cy": (1 + projection[1, 2]) * height / 2,
            "rotation": rotation.tolist(), "translation": (-rotation @ matrix[:3, 3]).tolist()}


def write(scene, depsgraph, folder):
    """cameras.json and the photographs, in `folder`; the name of the file."""
    cameras = with_photographs(scene)
    if not cameras:
        raise Refusal("no camera of the scene has a photograph: give cameras background images "
                      "(camera data > Background Images), or turn From cameras off")
    entries = []
    for number, camera in enumerate(cameras):
        picture = pictures.Picture(photograph_of(camera), f"photograph{number}")
        if picture.tiled:
            raise Refusal(f"photograph {picture.name} of camera {camera.name} has tiles: it has to be one picture")
        picture.save(folder)
        entries.append(entry_of(camera, depsgraph, *picture.image.size, picture.file))
    with open(os.path.join(folder, "cameras.json"), "w", encoding="utf-8") as file:
        json.dump({"cameras": entries}, file)
    return "cameras.json"
