"""Blender's window driven step by step by a generator: between its steps Blender's own loop goes on."""
import os
import sys
import time
import traceback

import bpy


def wait_until(true, what, seconds=120):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, what() if callable(what) else what
        yield


def press(key, x=400, y=400):
    window = bpy.context.window_manager.windows[0]
    if key == "LEFTMOUSE":
        window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    for value in ("PRESS", "RELEASE"):
        window.event_simulate(type=key, value=value, x=x, y=y)


def area(kind):
    return next(each for each in bpy.context.window_manager.windows[0].screen.areas if each.type == kind)


def in_view(call):
    """With the window and the 3D view as the context, as a press of a button has them."""
    window, view = bpy.context.window_manager.windows[0], area("VIEW_3D")
    region = next(each for each in view.regions if each.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=view, region=region):
        return call()


def drive(steps):
    """Runs the steps and ends Blender, with status 1 where one raises."""
    bpy.context.preferences.view.show_splash = False  # it would take the first key

    def step():
        try:
            next(steps)
            return 0.1
        except StopIteration:
            status = 0
        except BaseException:
            traceback.print_exc()
            status = 1
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)

    bpy.app.timers.register(step, first_interval=1)
