#!/usr/bin/env python3
"""What lies between two textures of one model, moved along their optical flow on the surface:

    05_interpolate.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
mesh = mq.sample("sphere", size=256).mesh
texels = mq.TexelSpace(mesh)


def spot(angle):
    """A bright spot on the sphere, at this angle around its axis."""
    towards = np.array([np.cos(angle), 0.3, np.sin(angle)])
    distance = np.linalg.norm(texels.positions() - towards / np.linalg.norm(towards), axis=1)
    values = 0.15 + 0.8 * np.exp(-(distance / 0.35) ** 2)
    return texels.scatter(np.repeat(values[:, None], 3, 1), mesh.pictures[0])


first, second = spot(0.0), spot(0.4)
between = mq.interpolate(mesh, first, second, time=0.5, longest_edge=6)
truth = texels.gather(spot(0.2))
mixed = (texels.gather(first) + texels.gather(second)) / 2


def error(signal):
    return np.sqrt(np.mean((signal - truth) ** 2)) * 255


print(f"error half-way, of 255: moved {error(texels.gather(between.picture)):.1f}, mixed {error(mixed):.1f}")
mq.render(mesh, texels.scatter(mixed, first), compare=between.picture, output=folder / "05_interpolate.png", size=480,
          view="90,20", title="mixed, and moved")
