"""The picture of docs/blender.md, into the file that is named: panels in both editors while a filter works."""
import os
import sys
import tempfile

import bpy

sys.path.insert(0, os.path.dirname(__file__))
import models  # noqa: E402
from windows import area, drive, in_view, press, wait_until  # noqa: E402


def open_panel(editor, below):
    """The tab of Marquetry, 180 pixels below the top of the sidebar, then one of its panels."""
    editor.spaces.active.show_region_ui = True
    yield
    yield
    sidebar = next(each for each in editor.regions if each.type == "UI")
    for right, down in ((10, 180), (170, below)):
        press("LEFTMOUSE", sidebar.x + sidebar.width - right, sidebar.y + sidebar.height - down)
        yield
        yield


def run(path):
    from marquetry_blender import job
    folder = tempfile.mkdtemp()
    models.program(folder, "sample", "bust", "--size", "1024", "-o", "./")
    bpy.context.window_manager.windows[0].workspace = bpy.data.workspaces["Texture Paint"]
    yield
    bpy.ops.object.mode_set(mode="OBJECT")
    models.empty_scene()
    in_view(lambda: bpy.ops.wm.obj_import(filepath=os.path.join(folder, "bust.obj")))
    bust = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = bust
    view = area("VIEW_3D")
    view.spaces.active.shading.type = "SOLID"
    view.spaces.active.shading.color_type = "TEXTURE"
    area("IMAGE_EDITOR").spaces.active.image = bpy.data.images["bust.png"]
    in_view(lambda: bpy.ops.view3d.view_axis(type="FRONT"))
    in_view(lambda: bpy.ops.view3d.view_selected())
    bpy.context.scene.marquetry.filter.beta, bpy.context.scene.marquetry.filter.length = 3, "3tx"
    yield from open_panel(area("IMAGE_EDITOR"), 312)  # Geodesic from Cursor
    yield from open_panel(area("VIEW_3D"), 156)  # Filter
    in_view(lambda: bpy.ops.marquetry.filter("INVOKE_DEFAULT"))
    work = job.at_work
    yield from wait_until(lambda: job.at_work is None or work.run.progress is not None, "no progress")
    yield
    bpy.ops.screen.screenshot(filepath=path)
    work.run.end()


models.install()
drive(run(os.path.abspath(sys.argv[sys.argv.index("--") + 1])))
