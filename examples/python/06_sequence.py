#!/usr/bin/env python3
"""Follows a sequence of meshes with one that changes only where it must, and reads what came of it:

    06_sequence.py [FOLDER]
"""
import pathlib
import sys

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
frames = folder / "06_frames" / "frame_%04d.ply"
mq.sample("merging", output=frames, frames="30-54x3", triangles=2000)

followed = mq.track(frames, output=folder / "06_merging.evolving", frames="30-54x3", remesh=True,
                    strip=folder / "06_sequence.png")
found = followed.report["result"]
print(f"{len(found['frames'])} frames followed")
mq.export(folder / "06_merging.evolving", output=folder / "06_frames" / "followed_%04d.ply")
