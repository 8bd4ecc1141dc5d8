#!/usr/bin/env python3
"""A filter of one's own from the matrices: anisotropic diffusion (Perona and Malik 1990) on the surface. In every step
values spread by (M + t S_c) phi = M psi, with a conductivity c = 1 / (1 + (|grad psi| / k)^2) that stops at edges.

    03_new_filter.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
mesh = mq.sample("bust", size=512).mesh
picture = mesh.pictures[0]
noisy = np.clip(picture + np.random.default_rng(0).normal(0, 20, picture.shape), 0, 255).astype(np.uint8)

space = mq.TexelSpace(mesh)
M = space.mass()
phi = space.gather(noisy)
for step in range(3):
    slope = space.gradient_norms(phi)
    conductivity = 1 / (1 + (slope / np.median(slope[slope > 0])) ** 2)
    solver = mq.Solver(space.weighted_system(1, space.weight("0.5tx"), conductivity), space)
    phi = solver.solve(M @ phi, guess=phi)
clean = space.scatter(phi, noisy)


def error(one):
    return np.sqrt(np.mean((space.gather(one) - space.gather(picture)) ** 2)) * 255


print(f"root mean square error, of 255: noisy {error(noisy):.1f}, diffused {error(clean):.1f}")
mq.render(mesh, noisy, compare=clean, output=folder / "03_new_filter.png", size=480, unlit=True, at="seam",
          extent="160tx")
