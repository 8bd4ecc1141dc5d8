"""The add-on with a window: panels, keys and undo, which only Blender's own loop has."""
import os
import sys
import traceback

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import models  # noqa: E402
from windows import area, drive, in_view, press, wait_until  # noqa: E402


def escape_leaves_everything():
    from marquetry_blender import job
    _, picture = models.painted_cube(size=1024)
    before = models.pixels(picture)
    # It would take minutes.
    assert in_view(lambda: bpy.ops.marquetry.denoise("INVOKE_DEFAULT", edge="0.2", steps=1000)) == {"RUNNING_MODAL"}
    work = job.at_work
    yield from wait_until(lambda: work.run.progress is not None, "no progress was told")
    press("ESC")
    yield from wait_until(lambda: job.at_work is None, "Escape did not stop it")
    assert work.run.process.returncode == 130, work.run.process.returncode
    np.testing.assert_array_equal(models.pixels(picture), before)
    assert not os.path.exists(work.folder)


def undo_and_redo():
    from marquetry_blender import job
    thing, _ = models.painted_cube()
    models.material(thing, models.image("other", seed=2))
    thing.data.polygons.foreach_set("material_index", [i % 2 for i in range(len(thing.data.polygons))])
    in_view(lambda: bpy.ops.ed.undo_push(message="painted"))

    def both():
        return [models.pixels(bpy.data.images[name]) for name in ("paint", "other")]

    before = both()
    in_view(lambda: bpy.ops.marquetry.filter("INVOKE_DEFAULT", beta="0"))
    yield from wait_until(lambda: job.at_work is None, "it did not end")
    after = both()
    assert not np.array_equal(after[0], before[0]) and not np.array_equal(after[1], before[1])
    # The last picture first; between two pictures is a step that changes nothing.
    for action, pictures in [("undo", (after[0], before[1])), ("undo", (after[0], before[1])), ("undo", before),
                             ("redo", (after[0], before[1])), ("redo", (after[0], before[1])), ("redo", after)]:
        in_view(getattr(bpy.ops.ed, action))
        yield
        np.testing.assert_array_equal(both(), pictures, action)


def undo_of_a_uv_map():
    from marquetry_blender import job
    models.painted_cube()
    in_view(lambda: bpy.ops.ed.undo_push(message="made"))
    in_view(lambda: bpy.ops.marquetry.unwrap("INVOKE_DEFAULT", size=128, trials=5))
    yield from wait_until(lambda: job.at_work is None, "it did not end")
    yield
    for action, names in [(None, ["UVMap", "Marquetry"]), (bpy.ops.ed.undo, ["UVMap"]),
                          (bpy.ops.ed.redo, ["UVMap", "Marquetry"])]:
        if action:
            in_view(action)
            yield
        assert [layer.name for layer in bpy.data.meshes["cube"].uv_layers] == names, (action, names)


def panels_are_drawn():
    """Every panel, opened, under a tab that both editors show first, so that what is wrong with one raises."""
    from marquetry_blender import panels
    models.painted_cube()
    bpy.context.scene.marquetry.show_all = True
    kinds, drawn, wrong = [each for each in panels.classes if issubclass(each, bpy.types.Panel)], set(), []

    def watched(kind):
        shown = kind.draw

        def draw(self, context):
            try:
                shown(self, context)
                drawn.add(kind.__name__)
            except BaseException:
                wrong.append(traceback.format_exc())

        return draw

    for kind in reversed(kinds):
        bpy.utils.unregister_class(kind)
    for kind in kinds:
        kind.draw, kind.bl_options = watched(kind), set()
        kind.bl_category = "Item" if kind.bl_space_type == "VIEW_3D" else "Tool"
        bpy.utils.register_class(kind)
    area("DOPESHEET_EDITOR").type = "IMAGE_EDITOR"
    for editor in ("VIEW_3D", "IMAGE_EDITOR"):
        # Panels below the end of the region are not drawn.
        place = area(editor)
        place.spaces.active.show_region_ui = True
        if editor == "IMAGE_EDITOR":
            place.spaces.active.image = bpy.data.images["paint"]
    yield from wait_until(lambda: wrong or len(drawn) == len(kinds), lambda: f"only {sorted(drawn)}", 30)
    assert not wrong, wrong[0]


def run():
    models.install()
    for part in (panels_are_drawn, undo_and_redo, undo_of_a_uv_map, escape_leaves_everything):
        print("window:", part.__name__, flush=True)
        models.empty_scene()
        yield from part()


drive(run())
