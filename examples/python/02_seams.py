#!/usr/bin/env python3
"""Smooths a texture twice: as a flat picture, as OpenCV does, and on the surface; how far are both sides of the
seams apart then?

    02_seams.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
mesh = mq.sample("bust", size=512).mesh
picture = mesh.pictures[0]


def steps_at_seams(picture):
    """Root mean square of the steps, 0 to 255, at the middles of all edges whose two faces have texture
    coordinates of their own."""
    seen, sides = {}, []
    for face, corners in enumerate(mesh.faces):
        for k in range(3):
            a, b = corners[k], corners[(k + 1) % 3]
            uv = mesh.uvs[face, [k, (k + 1) % 3]]
            other = seen.pop((b, a), None)
            if other is None:
                seen[a, b] = uv
            elif not np.array_equal(other[::-1], uv):
                sides.append((uv.mean(0), other.mean(0)))
    values = [lookup(picture, np.array(side)) for side in zip(*sides)]
    return np.sqrt(np.mean((values[0] - values[1]) ** 2))


def lookup(picture, uvs):
    """Bilinear, as a renderer does it."""
    height, width = picture.shape[:2]
    x, y = uvs[:, 0] * width - 0.5, (1 - uvs[:, 1]) * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - i)[:, None], (y - j)[:, None]
    p = np.asarray(picture, float)
    return ((1 - s) * (1 - t) * p[j, i] + s * (1 - t) * p[j, i + 1] + (1 - s) * t * p[j + 1, i]
            + s * t * p[j + 1, i + 1])


try:
    import cv2

    flat = cv2.GaussianBlur(np.asarray(picture), (0, 0), 5)
    who = "OpenCV"
except ImportError:
    space = mq.ImageSpace(picture)
    flat = space.scatter(mq.smooth(space, space.gather(picture), "5tx"), picture)
    who = "the flat picture"
surface = mq.filter(mesh, beta=0, length="5tx").picture

print(f"steps at seams, of 255: as it was {steps_at_seams(picture):.2f}, {who} {steps_at_seams(flat):.2f}, "
      f"on the surface {steps_at_seams(surface):.2f}")
mq.render(mesh, np.ascontiguousarray(flat), compare=surface, output=folder / "02_seams.png", size=480, at="seam",
          extent="96tx", title="flat, and on the surface")
