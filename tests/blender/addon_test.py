"""The add-on in Blender without a window: its pixels are the program's, and what is wrong is said in words."""
import glob
import os
import sys
import tempfile
import time
import unittest

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view

sys.path.insert(0, os.path.dirname(__file__))
import models  # noqa: E402

operators = bpy.ops.marquetry


class AddonTest(unittest.TestCase):
    def setUp(self):
        models.empty_scene()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def refused(self, words, call, **arguments):
        """The operator reports an error with these words; a traceback would be another kind of error."""
        with self.assertRaises(RuntimeError) as caught:
            call(**arguments)
        self.assertIn(words, str(caught.exception))
        self.assertNotIn("Traceback", str(caught.exception))
        self.assertEqual(glob.glob(os.path.join(bpy.app.tempdir, "marquetry_*")), [])


class Pixels(AddonTest):
    def test_are_those_of_the_program(self):
        thing, picture = models.painted_cube()
        before = models.pixels(picture)
        models.save_copy(picture, self.path("paint.png"))
        models.write_obj(thing, self.path("cube.obj"), ["paint.png"])
        models.program(self.folder, "filter", "cube.obj", "-o", "out.png", "--beta", "2.5", "--length", "3tx")
        expected = models.read(self.path("out.png"))
        self.assertEqual(operators.filter(beta="2.5", length="3tx"), {"FINISHED"})
        np.testing.assert_array_equal(models.pixels(picture), expected)
        self.assertGreater(np.abs(expected - before).max(), 0.05)

    def test_of_files_are_those_of_the_program_whatever_their_channels(self):
        from marquetry_blender.pictures import write_png
        for channels, name in [(1, "grey.png"), (3, "rgb.png"), (4, "rgba.png")]:
            with self.subTest(name):
                models.empty_scene()
                thing, _ = models.cube()
                values = np.random.default_rng(4).integers(0, 256, (64, 64, channels), np.uint8)
                write_png(self.path(name), values)
                picture = bpy.data.images.load(self.path(name))
                models.material(thing, picture)
                models.write_obj(thing, self.path("cube.obj"), [name])
                models.program(self.folder, "filter", "cube.obj", "-o", "out.png", "--beta", "0", "--length", "3tx")
                operators.filter(beta="0", length="3tx")
                np.testing.assert_array_equal(models.pixels(picture), models.read(self.path("out.png")))

    def test_of_floats_are_those_of_the_program(self):
        thing, picture = models.painted_cube(is_float=True)
        picture.pixels.foreach_set(models.pixels(picture).ravel() * np.float32(3.7))
        values = models.pixels(picture)
        values[..., 3] = 1
        picture.pixels.foreach_set(values.ravel())
        picture.file_format = "OPEN_EXR"
        picture.filepath_raw = self.path("paint.exr")
        picture.save()
        models.write_obj(thing, self.path("cube.obj"), ["paint.exr"])
        models.program(self.folder, "filter", "cube.obj", "-o", "out.exr", "--beta", "0", "--length", "3tx")
        operators.filter(beta="0", length="3tx")
        np.testing.assert_array_equal(models.pixels(picture), models.read(self.path("out.exr")))

    def test_of_two_materials_one_with_tiles_are_those_of_the_program(self):
        thing, plain, tiled = models.cube_with_tiles()
        models.save_copy(plain, self.path("plain.png"))
        models.save_copy(tiled, self.path("tiled.<UDIM>.png"))
        models.write_obj(thing, self.path("cube.obj"), ["plain.png", "tiled.<UDIM>.png", None])
        models.program(self.folder, "filter", "cube.obj", "-o", "out/", "--beta", "0", "--length", "4tx")
        operators.filter(beta="0", length="4tx")
        np.testing.assert_array_equal(models.pixels(plain), models.read(self.path("out/plain.png")))
        os.mkdir(self.path("after"))
        models.save_copy(tiled, self.path("after/tiled.<UDIM>.png"))
        models.save_copy(bpy.data.images["tiled before"], self.path("after/before.<UDIM>.png"))
        for tile in ("1001", "1002"):
            after = models.read(self.path(f"after/tiled.{tile}.png"))
            given = models.read(self.path(f"tiled.{tile}.png"))
            np.testing.assert_array_equal(after, models.read(self.path(f"out/tiled.{tile}.png")))
            np.testing.assert_array_equal(models.read(self.path(f"after/before.{tile}.png")), given)
            self.assertGreater(np.abs(after - given).max(), 0.02, tile)

    def test_of_normal_maps_are_told_in_the_axes_of_flat_shading(self):
        thing, picture = models.painted_cube()
        slopes = np.random.default_rng(6).normal(0, 0.2, (64, 64, 3)) + [0, 0, 1]
        values = np.ones((64, 64, 4), np.float32)
        values[..., :3] = (slopes / np.linalg.norm(slopes, axis=2, keepdims=True) + 1) / 2
        picture.pixels.foreach_set(values.ravel())
        models.save_copy(picture, self.path("map.png"))
        models.write_obj(thing, self.path("cube.obj"), ["map.png"], with_normals=True)
        models.program(self.folder, "filter", "cube.obj", "-o", "out.png", "--beta", "0", "--length", "4tx",
                       "--normal-space", "tangent")
        operators.filter(beta="0", length="4tx", normal_space="tangent")
        np.testing.assert_allclose(models.pixels(picture), models.read(self.path("out.png")), atol=1.01 / 255)

    def test_of_the_image_that_is_named_alone_change(self):
        thing, picture = models.painted_cube()
        other = models.image("other", seed=5)
        before, before_other = models.pixels(picture), models.pixels(other)
        operators.filter(beta="0", image="other")
        np.testing.assert_array_equal(models.pixels(picture), before)
        self.assertFalse(np.array_equal(models.pixels(other), before_other))

    def test_are_called_by_the_names_of_their_datablocks(self):
        from marquetry_blender.pictures import with_names_of_images
        names = {"picture0": "bust.png", "picture1": "skin"}
        said = "out/picture0.png: 7 values; picture1.1002.exr, surface.ply, mask.png"
        self.assertEqual(with_names_of_images(said, names), "bust.png: 7 values; skin.1002, surface.ply, mask.png")

    def test_of_new_images_are_kept_with_the_file(self):
        from marquetry_blender.pictures import new_image
        values = np.random.default_rng(7).random((8, 8, 3)).astype(np.float32) * 3
        for is_float, is_data in [(False, False), (True, False), (True, True)]:
            path = self.path(f"made_{is_float}_{is_data}.blend")
            new_image("made", values if is_float else values / 3, is_float, is_data)
            before = models.pixels(bpy.data.images["made"])
            if is_float:
                np.testing.assert_array_equal(before[..., :3], values)
            bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
            with bpy.data.libraries.load(path) as (held, wanted):
                wanted.images = ["made"]
            np.testing.assert_allclose(models.pixels(wanted.images[0]), before, rtol=1e-6, err_msg=path)
            models.empty_scene()

    def test_of_tiles_that_changed_meanwhile_are_kept(self):
        from marquetry_blender import pictures
        _, _, tiled = models.cube_with_tiles()
        os.makedirs(self.path("run/out"))
        saved = pictures.Picture(tiled, "p")
        for path in saved.save(self.path("run")):
            os.link(path, self.path("run/out", os.path.basename(path)))
        with bpy.context.temp_override(edit_image=tiled):  # the second tile, which is the active one
            bpy.ops.image.tile_fill(color=(0, 0.5, 0, 1), width=32, height=32, alpha=False)
        self.assertIn("changed meanwhile", saved.put(self.path("run/out"), "filter")[0][1])
        self.assertEqual(len(tiled.packed_files), 0)
        self.assertEqual(len(bpy.data.images["tiled filter"].packed_files), 2)

    def test_that_changed_meanwhile_are_kept(self):
        from marquetry_blender import pictures
        _, picture = models.painted_cube()
        saved = pictures.Picture(picture, "p")
        saved.save(self.folder)
        picture.pixels[0] = 1
        changed = models.pixels(picture)
        self.assertIn("changed meanwhile", saved.put(self.folder, "filter")[0][1])
        np.testing.assert_array_equal(models.pixels(picture), changed)
        self.assertIn("paint filter", bpy.data.images)


class Settings(AddonTest):
    def test_of_the_panel_count_unless_the_caller_gives_others(self):
        results = []
        for settings, arguments in [({}, {"beta": "0", "length": "6tx"}),
                                    ({"length": "6tx"}, {"beta": "0"}),
                                    ({"length": "1tx"}, {"beta": "0", "length": "6tx"}),
                                    ({"length": "1tx"}, {"beta": "0"})]:
            models.empty_scene()
            _, picture = models.painted_cube()
            for name, value in settings.items():
                setattr(bpy.context.scene.marquetry.filter, name, value)
            operators.filter(**arguments)
            results.append(models.pixels(picture))
            bpy.context.scene.marquetry.filter.length = ""
        np.testing.assert_array_equal(results[0], results[1])
        np.testing.assert_array_equal(results[0], results[2])
        self.assertFalse(np.array_equal(results[0], results[3]))

    def test_have_the_defaults_of_the_program(self):
        from marquetry_blender import options
        nothing = lambda row, name: self.fail(f"{row['name']} is {name} by default")
        for verb in ("filter", "texture", "stitch", "seams", "fill", "denoise", "shock", "geodesic", "unwrap", "bake"):
            group = getattr(bpy.context.scene.marquetry, verb)
            words = options.words_of(verb, lambda row: getattr(group, options.key(row)), nothing)
            self.assertEqual(words, [], verb)

    def test_of_modifiers_are_heeded(self):
        results = []
        for modifiers in (True, False):
            models.empty_scene()
            thing, picture = models.painted_cube()
            thing.modifiers.new("round", "SUBSURF").levels = 1
            operators.filter(beta="0", length="0.3", modifiers=modifiers)
            results.append(models.pixels(picture))
        self.assertFalse(np.array_equal(*results))


class Operators(AddonTest):
    def changed(self, name, **arguments):
        _, picture = models.painted_cube()
        before = models.pixels(picture)
        self.assertEqual(getattr(operators, name)(**arguments), {"FINISHED"})
        self.assertFalse(np.array_equal(models.pixels(picture), before), name)
        self.assertEqual(models.pixels(picture).shape, before.shape)

    def test_seams(self):
        self.changed("seams")

    def test_fill(self):
        self.changed("fill")

    def test_denoise(self):
        self.changed("denoise", edge="0.2")

    def test_shock(self):
        self.changed("shock")

    def test_stitch_charts(self):
        self.changed("stitch")

    def test_mask(self):
        mask = models.image("mask")
        black = np.zeros(64 * 64 * 4, np.float32)
        black[3::4] = 1
        mask.pixels.foreach_set(black)
        _, picture = models.painted_cube()
        before = models.pixels(picture)
        operators.filter(beta="0", mask="mask")
        np.testing.assert_array_equal(models.pixels(picture), before)

    def test_texture_from_a_camera(self):
        self.photographed_floor(1)

    def test_texture_of_a_mirrored_object(self):
        self.photographed_floor(-1)

    def photographed_floor(self, scale):
        mesh = bpy.data.meshes.new("floor")
        mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
        mesh.uv_layers.new().data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
        thing = bpy.data.objects.new("floor", mesh)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        for each in (thing, camera):
            bpy.context.scene.collection.objects.link(each)
        bpy.context.view_layer.objects.active = thing
        thing.scale.x = scale
        picture = models.image("paint", 32)
        models.material(thing, picture)
        # A photograph whose colours are its own coordinates.
        photograph = bpy.data.images.new("photograph", 200, 120)
        y, x = np.mgrid[0:120, 0:200]
        colours = np.stack([(x + 0.5) / 200, (y + 0.5) / 120, 0 * x, 0 * x + 1], 2)
        photograph.pixels.foreach_set(colours.astype(np.float32).ravel())
        camera.data.show_background_images = True
        camera.data.background_images.new().image = photograph
        camera.data.lens, camera.data.shift_x, camera.data.shift_y = 24, 0.05, -0.03
        camera.location, camera.rotation_euler = (0.3, -0.4, 5), (0.1, 0.05, 0.7)
        bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 200, 120
        bpy.context.view_layer.update()
        operators.texture(alpha="0", blend="best", poses="keep")
        found = models.pixels(picture)
        from mathutils import Vector
        middles = (np.arange(32) + 0.5) / 16 - 1
        expected = np.array([[world_to_camera_view(bpy.context.scene, camera, Vector((scale * x, y, 0)))[:2]
                              for x in middles] for y in middles])
        # Near outlines no photograph counts: there it is filled.
        inner = slice(3, -3)
        np.testing.assert_allclose(found[inner, inner, :2], expected[inner, inner], atol=2 / 255)
        self.assertGreater(np.ptp(expected), 0.2)

    def test_unwrap_then_bake(self):
        thing, picture = models.painted_cube(size=128)
        picture.pixels.foreach_set(np.tile(np.float32([0.2, 0.4, 0.6, 1]), 128 * 128))
        area = sum(polygon.area for polygon in thing.data.polygons)
        operators.unwrap(size=128, trials=5)
        mesh = thing.data
        self.assertEqual([layer.name for layer in mesh.uv_layers], ["UVMap", "Marquetry"])
        self.assertEqual(mesh.uv_layers.active.name, "Marquetry")
        self.assertAlmostEqual(sum(polygon.area for polygon in mesh.polygons), area, 4)
        uvs = np.empty(2 * len(mesh.loops), np.float32)
        mesh.uv_layers.active.data.foreach_get("uv", uvs)
        self.assertTrue(np.all((uvs >= 0) & (uvs <= 1)) and np.ptp(uvs) > 0.5)
        self.assertEqual(operators.bake(size="128"), {"FINISHED"})
        baked = models.pixels(bpy.data.images["cube baked"])
        self.assertEqual(baked.shape, (128, 128, 4))
        for polygon in mesh.polygons:
            u, v = np.mean([mesh.uv_layers.active.data[i].uv for i in polygon.loop_indices], 0)
            np.testing.assert_allclose(baked[int(v * 128), int(u * 128), :3], [0.2, 0.4, 0.6], atol=1 / 255)

    def test_unwrap_cuts_polygons_where_seams_cross_them(self):
        from marquetry_blender import surface, uv_maps
        thing, _ = models.cube()
        thing.shape_key_add(name="rest")
        thing.shape_key_add(name="moved").data[5].co.z += 0.5
        whole = surface.Surface(thing.data, thing.matrix_world, None)
        uvs = np.random.default_rng(3).random((len(whole.vertices), 3, 2)).astype(np.float32)
        self.assertEqual(uv_maps.give(thing, whole, uvs, "new"), 54)
        mesh = thing.data
        self.assertEqual(len(mesh.polygons), 108)
        rest, moved = (key.data[5].co.z for key in mesh.shape_keys.key_blocks)
        self.assertAlmostEqual(moved - rest, 0.5)
        wanted = {frozenset((int(v), *map(float, uv)) for v, uv in zip(*each)) for each in zip(whole.vertices, uvs)}
        layer = mesh.uv_layers["new"].data
        found = {frozenset((mesh.loops[i].vertex_index, *layer[i].uv) for i in polygon.loop_indices)
                 for polygon in mesh.polygons}
        self.assertEqual(found, wanted)

    def test_geodesic_into_images(self):
        models.painted_cube()
        bpy.context.scene.cursor.location = (0, 0, 1)
        operators.geodesic(show="numbers")
        models.save_copy(bpy.data.images["paint"], self.path("paint.png"))
        models.write_obj(bpy.context.object, self.path("cube.obj"), ["paint.png"])
        models.program(self.folder, "geodesic", "cube.obj", "--from=0,0,1", "-o", "out.exr")
        values = models.pixels(bpy.data.images["cube distance"])
        np.testing.assert_array_equal(values, models.read(self.path("out.exr")))
        self.assertTrue(bpy.data.images["cube distance"].is_float and 3 < values.max() < 5)
        bpy.data.images["cube distance"].reload()  # as from the saved file
        np.testing.assert_array_equal(models.pixels(bpy.data.images["cube distance"]), values)
        operators.geodesic()
        self.assertIn("cube distance.001", bpy.data.images)

    def test_geodesic_into_tiles(self):
        models.cube_with_tiles()
        bpy.context.scene.cursor.location = (0, 0, 1)
        for show, ending in [("numbers", "exr"), ("colours", "png")]:
            operators.geodesic(show=show)
            made = [image for image in bpy.data.images if image.name.startswith("cube distance")]
            self.assertEqual(sorted(image.source for image in made), ["FILE", "TILED"])
            tiled = next(image for image in made if image.source == "TILED")
            os.mkdir(self.path(show))
            models.save_copy(tiled, self.path(show, "t.<UDIM>." + ending))
            for number, size in [("1001", 64), ("1002", 32)]:
                values = models.read(self.path(show, f"t.{number}.{ending}"))
                self.assertEqual(values.shape[:2], (size, size))
                self.assertGreater(values[..., :3].max(), 1.5 if show == "numbers" else 0.3)
            for image in made:
                bpy.data.images.remove(image)

    def test_geodesic_of_an_object_without_images(self):
        models.cube()
        operators.geodesic(show="numbers")
        self.assertEqual(tuple(bpy.data.images["cube distance"].size), (1024, 1024))

    def test_geodesic_into_vertices(self):
        thing, _ = models.cube(parts=16)
        thing.location = (3, 0, 0)
        bpy.context.view_layer.update()
        bpy.context.scene.cursor.location = (3, 0, 1)
        operators.geodesic(into="VERTICES", show="numbers")
        for vertex, each in zip(thing.data.vertices, thing.data.attributes["distance"].data):
            if vertex.co.z == 1:
                self.assertAlmostEqual(each.value, vertex.co.xy.length, delta=0.1)
            else:
                self.assertGreater(each.value, 0.9)
        operators.geodesic(into="VERTICES")
        self.assertEqual(thing.data.color_attributes.active_color.name, "distance colours")


class Stopped(AddonTest):
    def start(self, finished):
        """A run that would take minutes, and its picture."""
        from marquetry_blender import job, scene
        thing, picture = models.painted_cube(size=1024)

        def prepare(folder):
            surface, slots = scene.surface_of(bpy.context, thing, "UVMap", True)
            images, table = scene.images_of(thing, slots, None)
            saved = scene.save_pictures(images, folder)
            surface.write(os.path.join(folder, "surface.ply"), [each.file for each in saved], table)
            return ["surface.ply", "-o", "out/", "--edge", "0.2", "--steps", "1000"]

        return picture, job.Job("denoise", prepare, lambda folder: finished.append(folder) or [])

    def test_by_escape_in_the_middle_leaves_the_datablock_as_it_was(self):
        from marquetry_blender import job
        finished = []
        picture, work = self.start(finished)
        before = models.pixels(picture)
        while work.run.progress is None:
            self.assertEqual(work.step("TIMER")[0], "RUNNING_MODAL", "it was done before it could be stopped")
            time.sleep(0.05)
        self.assertRegex(work.run.words(), r"\d+ % .*Esc cancels")
        with self.assertRaisesRegex(RuntimeError, "Marquetry is at work"):
            operators.filter(beta="0")
        state, told = work.step("ESC")
        deadline = time.monotonic() + 30
        while state == "RUNNING_MODAL" and time.monotonic() < deadline:
            time.sleep(0.05)
            state, told = work.step("TIMER")
        self.assertEqual((state, told), ("CANCELLED", [("INFO", "Cancelled: nothing is changed")]))
        self.assertEqual(finished, [])
        self.assertFalse(os.path.exists(work.folder))
        np.testing.assert_array_equal(models.pixels(picture), before)
        self.assertIsNone(job.at_work)

    def test_with_the_addon(self):
        from marquetry_blender import job
        finished = []
        _, work = self.start(finished)
        bpy.ops.preferences.addon_disable(module="marquetry_blender")
        try:
            self.assertIsNotNone(work.run.process.poll())
            self.assertFalse(os.path.exists(work.folder))
            self.assertEqual((finished, job.at_work), ([], None))
        finally:
            bpy.ops.preferences.addon_enable(module="marquetry_blender")
            models.preferences().program = models.PROGRAM


class WrongInput(AddonTest):
    def test_no_object(self):
        bpy.context.view_layer.objects.active = None
        self.refused("no mesh is active", operators.filter, beta="0")

    def test_no_faces(self):
        thing = bpy.data.objects.new("none", bpy.data.meshes.new("none"))
        bpy.context.scene.collection.objects.link(thing)
        bpy.context.view_layer.objects.active = thing
        self.refused("has no faces", operators.unwrap)
        self.refused("has no UV map", operators.filter, beta="0")

    def test_no_image(self):
        thing, _ = models.cube()
        self.refused("has an image", operators.filter, beta="0")
        self.refused("there is no image other", operators.filter, beta="0", image="other")

    def test_edit_mode(self):
        models.painted_cube()
        bpy.ops.object.mode_set(mode="EDIT")
        try:
            self.refused("is in edit mode", operators.seams)
        finally:
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_missing_file(self):
        thing, picture = models.painted_cube()
        picture.source = "FILE"
        picture.filepath = self.path("gone.png")
        picture.reload()
        self.refused("is missing", operators.filter, beta="0")

    def test_linked_image(self):
        _, picture = models.painted_cube()
        picture.pack()
        bpy.data.libraries.write(self.path("library.blend"), {picture})
        models.empty_scene()
        with bpy.data.libraries.load(self.path("library.blend"), link=True) as (held, wanted):
            wanted.images = held.images
        thing, _ = models.cube()
        models.material(thing, wanted.images[0])
        self.refused("make it local", operators.filter, beta="0")

    def test_program(self):
        models.painted_cube()
        fake = self.path("marquetry")
        for text, words in [(None, "is no program"), ("echo marquetry 9.9", "is version 9.9"),
                            ("echo hello", "says 'hello'")]:
            if text:
                with open(fake, "w", encoding="utf-8") as file:
                    file.write(f"#!/bin/sh\n{text}\n")
                os.chmod(fake, 0o755)
            models.preferences().program = fake
            try:
                self.refused(words, operators.filter, beta="0")
            finally:
                models.preferences().program = models.PROGRAM
        path, os.environ["PATH"] = os.environ["PATH"], self.folder + "/nothing"
        models.preferences().program = ""
        try:
            self.refused("not on PATH", operators.filter, beta="0")
        finally:
            os.environ["PATH"], models.preferences().program = path, models.PROGRAM

    def test_values(self):
        models.painted_cube()
        self.refused("--length", operators.filter, beta="0", length="three")
        self.refused("there is no image no", operators.filter, beta="0", mask="no")

    def test_bake_to_the_same_uv_map(self):
        models.painted_cube()
        self.refused("is the one that renders", operators.bake)

    def test_no_cameras(self):
        models.painted_cube()
        self.refused("no camera of the scene", operators.texture)


if __name__ == "__main__":
    models.install()
    chosen = sys.argv[sys.argv.index("--") + 1:]
    result = unittest.main(module=__name__, argv=["addon_test", *chosen], exit=False).result
    if not result.wasSuccessful():
        raise SystemExit(1)
