#!/usr/bin/env python3
"""Sharpens the texture of a scan on its surface, over all seams, and shows both:

    01_filter.py [FOLDER [MESH TEXTURE]]
"""
import pathlib
import sys

import marquetry as mq

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
scan = sys.argv[2:4] or [mq.sample("bust", size=512).mesh]

sharp = mq.filter(*scan, beta=2.5, length="4tx")
print(f"changed by at most {sharp.report['result']['largest_change']:.2f}, in "
      f"{sharp.report['seconds']['total']:.1f} s")
mq.render(*scan, compare=sharp.picture, output=folder / "01_filter.png", size=480)
