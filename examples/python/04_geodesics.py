#!/usr/bin/env python3
"""Distances along a surface, from texels and from vertices:

    04_geodesics.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
mesh = mq.sample("genus4", size=512).mesh

# The verb, from a point in space, as numbers and as colours.
place = tuple(mesh.vertices[0])
distance = mq.geodesic(mesh, from_=place).picture
colours = mq.geodesic(mesh, from_=place, show="colours", isolines=30).picture

# The equation, prepared once for many sources: here the vertex farthest from those before it, five times.
space = mq.VertexSpace(mesh)
equation = mq.GeodesicDistance(space)
sources = [0]
while len(sources) < 6:
    sources.append(int(np.argmax(equation.from_(sources))))
print(f"farthest by the texture {distance.max():.3f}, by vertices {equation.from_(0).max():.3f}; "
      f"six places spread out: {sources}")
mq.render(mesh, colours, unlit=True, output=folder / "04_geodesics.png", size=640, view="30,50")
