"""Marquetry: signal processing on textured triangle meshes.

Every verb of the program is a function with the verb's options as keywords:

    import marquetry as mq
    mq.filter("bust.obj", "bust.png", output="sharp.png", beta=3)      # files
    sharp = mq.filter(mesh, picture, beta=3, length="3tx").picture     # arrays
    print(mq.filter.__doc__)

marquetry.fem has the signal spaces, their matrices and prepared equations for filters of one's own.
"""
from __future__ import annotations

from . import _verbs, fem
from ._errors import Cancelled, Error, InvalidInput, IoError, OutOfMemory, SolverError, Unsupported, Warning
from ._marquetry import version as __version__
from ._meshes import Mesh
from ._pictures import Picture, as_picture
from ._results import Result
from ._verbs import *  # noqa: F401,F403
from .fem import GeodesicDistance, ImageSpace, ScreenedPoisson, Solver, TexelSpace, VertexSpace, sharpen, smooth

__all__ = ["Cancelled", "Error", "GeodesicDistance", "ImageSpace", "InvalidInput", "IoError", "Mesh", "OutOfMemory",
           "Picture", "Result", "ScreenedPoisson", "Solver", "SolverError", "TexelSpace", "Unsupported", "VertexSpace",
           "Warning", "as_picture", "fem", "sharpen", "smooth", *_verbs.__all__]
