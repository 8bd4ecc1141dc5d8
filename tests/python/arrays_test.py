"""Arrays in, arrays out: the same values as by files, from whatever holds them."""
import contextlib
import io
import json
import logging
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import warnings

import numpy as np

import marquetry as mq
from models import arrays, folder, mesh, program, read_png, sample


def by_program(verb, *words, model="bust", size=128, out="out.png"):
    """The picture that the program makes of a sample."""
    made = sample(model, size)
    output = folder() / f"{verb}_{out}"
    program(verb, made / f"{model}.obj", made / f"{model}.png", "-o", output, *words)
    return read_png(output)


class SameValues(unittest.TestCase):
    """Verbs that make pictures, on arrays."""

    def check(self, verb, words, **options):
        made = getattr(mq, verb)(mesh(), **options)
        np.testing.assert_array_equal(made.picture, by_program(verb, *words))
        return made

    def test_filter(self):
        made = self.check("filter", ["--beta", 3, "--length", "3tx"], beta=3, length="3tx")
        self.assertEqual(made.picture.dtype, np.uint8)
        self.assertEqual(made.files, [])
        np.testing.assert_array_equal(np.asarray(made), made.picture)

    def test_others(self):
        self.check("denoise", [])
        self.check("seams", [])
        self.check("fill", [])
        self.check("mask", ["--what", "chart"], what="chart")
        self.check("lic", [])
        self.check("shock", ["--time", 2], time=2)
        self.check("react", ["--time", 20, "--scale", "5%"], time=20, scale="5%")
        self.check("render", ["--size", 96], size=96)

    def test_stitch_takes_labels_as_arrays(self):
        *_, picture = arrays()
        labels = (picture[:, :, 0] > 128).astype(np.uint8) * 255
        from PIL import Image
        Image.fromarray(labels).save(folder() / "labels.png")
        self.check("stitch", ["--labels", folder() / "labels.png"], labels=labels)

    def test_filter_takes_masks_as_arrays(self):
        mask = np.zeros((128, 128), np.uint8)
        mask[:64] = 255
        from PIL import Image
        Image.fromarray(mask).save(folder() / "mask.png")
        self.check("filter", ["--beta", 0, "--mask", folder() / "mask.png"], beta=0, mask=mask)

    def test_geodesic_gives_numbers(self):
        made = mq.geodesic(mesh(), from_="texel,64,64")
        self.assertEqual(made.picture.dtype, np.float32)
        output = folder() / "distance.exr"
        made_there = sample()
        report = json.loads(program("geodesic", made_there / "bust.obj", made_there / "bust.png", "-o", output,
                                    "--from", "texel,64,64", "--json"))
        self.assertAlmostEqual(made.report["result"]["max"], report["result"]["max"], places=12)
        self.assertAlmostEqual(float(made.picture.max()), report["result"]["max"], delta=0.1)
        point = mesh().vertices[0]
        np.testing.assert_array_equal(mq.geodesic(mesh(), from_=tuple(point)).picture,
                                      mq.geodesic(mesh(), from_=[",".join(map(repr, map(float, point)))]).picture)

    def test_unwrap_of_arrays(self):
        vertices, faces, _, _ = arrays()
        made = mq.unwrap(vertices, faces, size=256)
        self.assertEqual(made.mesh.uvs.shape, (len(faces), 3, 2))
        np.testing.assert_array_equal(made.mesh.faces, faces)
        output = folder() / "unwrapped.ply"
        program("unwrap", sample() / "bust.obj", "-o", output, "--size", 256)
        self.assertTrue(((made.mesh.uvs >= 0) & (made.mesh.uvs <= 1)).all())
        space = mq.TexelSpace(made.mesh, 64)
        self.assertGreater(space.size, 1000)

    def test_bake_between_meshes(self):
        target = mesh("bust_4")
        made = mq.bake(mesh(), target, size=64)
        output = folder() / "baked.png"
        program("bake", sample() / "bust.obj", sample("bust_4") / "bust_4.obj", sample() / "bust.png", "-o", output,
                "--size", 64)
        np.testing.assert_array_equal(made.picture, read_png(output))

    def test_remesh(self):
        made = mq.remesh(mesh(), mesh("bust_4"))
        self.assertGreater(len(made.mesh.faces), 100)

    def test_colours_at_vertices(self):
        vertices, faces, _, _ = arrays()
        colors = np.random.default_rng(6).integers(0, 255, (len(vertices), 3), np.uint8)
        made = mq.filter(mq.Mesh(vertices, faces, colors=colors), beta=0, length="5%", vertices=True)
        self.assertEqual(made.mesh.colors.dtype, np.uint8)
        self.assertLess(made.mesh.colors.std(), colors.std())
        shape = mq.filter(mq.Mesh(vertices, faces), beta=0, geometry=True)
        self.assertEqual(shape.mesh.vertices.shape, vertices.shape)
        self.assertGreater(np.abs(shape.mesh.vertices - vertices).max(), 0)

    def test_flow_and_interpolation_of_pictures(self):
        *_, picture = arrays()
        moved = np.roll(picture, 2, axis=1)
        flow = mq.flow(picture, moved)
        field = next(one for one in flow.images.values() if one.ndim == 3 and one.shape[2] == 2)
        self.assertEqual(field.shape, (128, 128, 2))
        self.assertAlmostEqual(float(np.median(field[30:-30, 30:-30, 0])), 2, delta=0.3)
        between = mq.interpolate(picture, moved, time=0.5)
        self.assertEqual(between.picture.shape, picture.shape)

    def test_interpolation_of_textures(self):
        vertices, faces, uvs, picture = arrays()
        second = mq.filter(mesh(), beta=0, length="2tx").picture
        made = mq.interpolate(mq.Mesh(vertices, faces, uvs), picture, second, time=0.5, longest_edge=8)
        self.assertEqual(made.picture.shape, picture.shape)

    def test_spectrum_gives_fields(self):
        made = mq.spectrum(mesh(), count=2, output=None)
        self.assertEqual(len(made.report["result"]["eigenvalues"]), 2)
        self.assertEqual(len(made.fields), 2)
        for field in made.fields.values():
            self.assertEqual(field.shape, (len(mesh().faces), 3))
            self.assertGreater(np.abs(field).max(), 0)

    def test_fields_are_taken_apart(self):
        made = mq.fields(mesh(), field="max-curvature")
        parts = {name.rsplit("_", 1)[-1].removesuffix(".ply"): field for name, field in made.fields.items()}
        self.assertEqual(set(parts), {"whole", "gradient", "curl", "harmonic"})
        np.testing.assert_allclose(parts["gradient"] + parts["curl"] + parts["harmonic"], parts["whole"],
                                   atol=1e-9 * np.abs(parts["whole"]).max())

    def test_sample_is_a_mesh(self):
        made = mq.sample("cube", size=32)
        self.assertEqual(made.mesh.pictures[0].shape, (32, 32, 3))
        self.assertGreater(mq.TexelSpace(made.mesh).size, 100)


class Inputs(unittest.TestCase):
    def test_depths_stay(self):
        *_, picture = arrays()
        model = arrays()[:3]
        eight = mq.filter(model, picture, beta=2).picture
        sixteen = mq.filter(model, picture.astype(np.uint16) * 257, beta=2).picture
        floats = mq.filter(model, (picture / 255).astype(np.float32), beta=2).picture
        self.assertEqual((eight.dtype, sixteen.dtype, floats.dtype), (np.uint8, np.uint16, np.float32))
        self.assertLessEqual(np.abs(sixteen / 65535 - floats.clip(0, 1)).max(), 1e-5)
        self.assertLessEqual(np.abs(eight / 255 - floats.clip(0, 1)).max(), 0.5 / 255 + 1e-6)

    def test_steps_of_any_kind(self):
        model, picture = arrays()[:3], arrays()[3]
        wanted = mq.filter(model, picture, beta=2).picture
        for other in (np.asfortranarray(picture), picture[::-1][::-1], np.repeat(picture, 2, axis=1)[:, ::2],
                      np.concatenate([picture, picture], axis=2)[:, :, :3]):
            np.testing.assert_array_equal(mq.filter(model, other, beta=2).picture, wanted)

    def test_other_libraries_objects(self):
        from PIL import Image
        vertices, faces, uvs, picture = arrays()
        wanted = mq.filter(mesh(), beta=2).picture
        np.testing.assert_array_equal(mq.filter(arrays()[:3], Image.fromarray(picture), beta=2).picture, wanted)
        image = Image.fromarray(picture)
        for mode, plain in (("PA", "RGBA"), ("RGBa", "RGBA"), ("La", "LA"), ("RGBX", "RGB")):
            odd = image.convert("P").convert(mode) if mode == "PA" else image.convert(plain).convert(mode)
            np.testing.assert_array_equal(mq.filter(arrays()[:3], odd, beta=2).picture,
                                          mq.filter(arrays()[:3], odd.convert(plain), beta=2).picture, mode)
        interface = types.SimpleNamespace(__array_interface__=np.ascontiguousarray(picture).__array_interface__)
        np.testing.assert_array_equal(mq.filter(arrays()[:3], interface, beta=2).picture, wanted)
        np.testing.assert_array_equal(mq.filter(vertices, faces, uvs, picture, beta=2).picture, wanted)
        flat = vertices[faces].reshape(-1, 3)
        visual = types.SimpleNamespace(uv=uvs.reshape(-1, 2),
                                       material=types.SimpleNamespace(image=Image.fromarray(picture)))
        scene = types.SimpleNamespace(vertices=flat, faces=np.arange(len(flat)).reshape(-1, 3), visual=visual)
        np.testing.assert_array_equal(mq.filter(scene, beta=2).picture, wanted)
        opened = types.SimpleNamespace(vertices=vertices, triangles=faces, triangle_uvs=uvs.reshape(-1, 2),
                                       textures=[picture[::-1]], vertex_colors=np.zeros((0, 3)),
                                       triangle_material_ids=np.zeros(len(faces), int))
        np.testing.assert_array_equal(mq.filter(opened, beta=2).picture, wanted)

    def test_colours_at_vertices_of_trimesh(self):
        vertices, faces = arrays()[:2]
        colours = np.random.default_rng(7).integers(0, 255, (len(vertices), 3), np.uint8)
        wanted = mq.filter(mq.Mesh(vertices, faces, colors=colours), vertices=True, beta=0).mesh.colors
        opaque = np.concatenate([colours, np.full((len(vertices), 1), 255, np.uint8)], axis=1)

        def scene(kind):
            visual = types.SimpleNamespace(kind=kind, vertex_colors=opaque)
            return types.SimpleNamespace(vertices=vertices, faces=faces, visual=visual)
        np.testing.assert_array_equal(mq.filter(scene("vertex"), vertices=True, beta=0).mesh.colors, wanted)
        with self.assertRaises(mq.InvalidInput):  # those that it makes up where there are none
            mq.filter(scene(None), vertices=True, beta=0)

    def test_pictures_and_textures_are_counted(self):
        vertices, faces, uvs, picture = arrays()
        with self.assertRaisesRegex(mq.InvalidInput, "mesh has 1 texture, but 3 pictures are given"):
            mq.filter(mq.Mesh(vertices, faces, uvs, pictures=[picture] * 3), beta=2)
        with self.assertRaisesRegex(mq.InvalidInput, "has 1 texture.*but 3 pictures are given"):
            mq.filter(sample() / "bust.obj", [picture] * 3, beta=2)
        np.testing.assert_array_equal(mq.filter(sample() / "bust.obj", [picture], beta=2).picture,
                                      mq.filter(sample() / "bust.obj", picture, beta=2).picture)

    def test_files_and_arrays_mixed(self):
        made = sample()
        result = mq.filter(str(made / "bust.obj"), arrays()[3], beta=2)
        np.testing.assert_array_equal(result.picture, mq.filter(mesh(), beta=2).picture)
        output = folder() / "mixed.png"
        written = mq.filter(mesh(), output=output, beta=2)
        self.assertEqual(written.files, [output])
        np.testing.assert_array_equal(read_png(output), result.picture)

    def test_pictures_show_themselves(self):
        data = mq.filter(mesh(), beta=2)._repr_png_()
        (folder() / "shown.png").write_bytes(data)
        np.testing.assert_array_equal(read_png(folder() / "shown.png"), mq.filter(mesh(), beta=2).picture)
        grey = mq.as_picture(np.arange(12, dtype=np.uint16).reshape(3, 4) * 4000)
        grey.save(folder() / "grey.png")
        np.testing.assert_array_equal(read_png(folder() / "grey.png"), grey)

    def test_what_is_computed_of_pictures_is_none(self):
        picture = mq.filter(mesh(), beta=2).picture
        self.assertIsInstance(picture.mean(), float)
        self.assertEqual(type(picture.max()), np.uint8)
        for made in (picture + 1, picture == picture, picture.astype(float) * 2):
            self.assertEqual(type(np.asarray(made)), np.ndarray)
        self.assertEqual(type(picture == picture), np.ndarray)
        self.assertIsInstance(picture[:4, :4], type(picture))

    def test_masks_may_be_of_truth_values(self):
        chosen = np.zeros(arrays()[3].shape[:2], bool)
        chosen[:8] = True
        np.testing.assert_array_equal(mq.filter(mesh(), beta=2, mask=chosen).picture,
                                      mq.filter(mesh(), beta=2, mask=chosen.astype(np.uint8) * 255).picture)

    def test_sequences_are_lists_of_meshes(self):
        vertices, faces, _, _ = arrays()
        moved = [vertices + [0, 0, 0.01 * frame] for frame in range(3)]
        for frame, positions in enumerate(moved):
            (folder() / f"moved_{frame}.obj").write_text(
                "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in positions.tolist())
                + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces.tolist()))
        ours = mq.track(((positions, faces) for positions in moved), output=folder() / "ours.evolving")
        files = mq.track(str(folder() / "moved_%d.obj"), output=folder() / "files.evolving")
        self.assertEqual((folder() / "ours.blocks").read_bytes(), (folder() / "files.blocks").read_bytes())
        self.assertEqual(len(ours.report["result"]["frames"]), len(files.report["result"]["frames"]))
        with self.assertRaisesRegex(mq.InvalidInput, r"^sequence\[1\]: found vertices of shape"):
            mq.track([(vertices, faces), (np.full((3, 3), np.nan), faces)], output=folder() / "bad.evolving")
        with self.assertRaisesRegex(TypeError, "^sequence: found int, wanted a path, or a list"):
            mq.track(3, output=folder() / "bad.evolving")

    def test_no_thread_count_changes_a_bit(self):
        np.testing.assert_array_equal(mq.filter(mesh(), beta=3, threads=1).picture,
                                      mq.filter(mesh(), beta=3, threads=3).picture)


class Words(unittest.TestCase):
    def test_errors_have_the_librarys_words_and_pythons_names(self):
        with self.assertRaisesRegex(mq.InvalidInput, "^beta: found 'nan', wanted a number") as caught:
            mq.filter(mesh(), beta=float("nan"))
        self.assertIsInstance(caught.exception, ValueError)
        broken = arrays()[3].astype(np.float32)
        broken[2, 3] = np.nan
        with self.assertRaisesRegex(mq.InvalidInput, "^texture: found .*nan.* at row 2, column 3") as caught:
            mq.filter(mesh(), broken, beta=2)
        with self.assertRaisesRegex(mq.InvalidInput, "alpha and length contradict each other"):
            mq.filter(mesh(), beta=1, alpha=1e-3, length="1%")
        with self.assertRaisesRegex(mq.InvalidInput, "smooth_normals"):
            mq.filter(mesh(), beta=1, smooth_normals="far")
        with self.assertRaisesRegex(mq.IoError, "no_such.obj") as caught:
            mq.filter("no_such.obj", beta=1)
        self.assertIsInstance(caught.exception, OSError)
        with self.assertRaisesRegex(mq.InvalidInput, "strength 50% .*\n *marquetry filter .* --strength 50% -o "):
            mq.filter(mesh())
        with self.assertRaises(TypeError):
            mq.filter(mesh(), beta=1, lenght="1%")
        with self.assertRaisesRegex(mq.Unsupported, "track writes files"):
            mq.track("frame_%04d.ply")
        with self.assertRaisesRegex(mq.IoError, "write it to a file"):
            mq.texture(mesh(), cameras=arrays()[3])
        with self.assertRaisesRegex(mq.InvalidInput, "^mesh"):
            mq.filter(mq.Mesh(np.zeros((3, 3)), np.zeros((0, 3), int)), beta=1)

    def test_values_of_other_types(self):
        for options, words in (({"beta": [3]}, r"^beta: found \[3\], wanted a number$"),
                               ({"beta": 10**400}, r"^beta: found 10+\.\.\., wanted a number$"),
                               ({"beta": 1, "threads": 1.5}, "^threads: found 1.5, wanted a whole number$")):
            with self.assertRaisesRegex(TypeError, words):
                mq.filter(mesh(), **options)
        with self.assertRaisesRegex(mq.InvalidInput, r"^output: found '\\ud800.png', which no file"):
            mq.filter(mesh(), beta=1, output="\ud800.png")
        for size in ("512", (512.0, 512.0), None, True):
            with self.assertRaisesRegex(TypeError, r"^sizes: found .*, wanted a side, \(width, height\), a picture"):
                mq.TexelSpace(mesh(), [size])
        space = mq.VertexSpace(mesh())
        for call, words in ((lambda: mq.ScreenedPoisson(space, "3tx"), r"^weight: found '3tx', wanted a number, such as"),
                            (lambda: mq.GeodesicDistance(space.mass()), "^space: found csr_matrix, wanted a TexelSpace"),
                            (lambda: mq.smooth(None, [1], "3tx"), "^space: found NoneType"),
                            (lambda: space.system("a", 1), "^a: found 'a', wanted a number"),
                            (lambda: mq.Mesh([[0, 0, 0]], None), "^faces: found None, wanted an array"),
                            (lambda: mq.VertexSpace("bust.obj"), "^mesh: found str, wanted a Mesh"),
                            (lambda: mq.evolve([], output="a.evolving"), "^sequence: found an empty list, wanted"),
                            (lambda: mq.filter({}, beta=1), "^mesh: found dict, wanted a path, a mesh"),
                            (lambda: mq.filter(mesh(), beta=1, output=io.BytesIO()), "^output: .*, wanted a path$")):
            with self.assertRaisesRegex(TypeError, words):
                call()
        with self.assertRaisesRegex(mq.InvalidInput, "^sizes: found an empty list, wanted a side"):
            mq.TexelSpace(mesh(), [])
        with self.assertRaisesRegex(mq.InvalidInput, "^unknowns: found none"):
            mq.GeodesicDistance(space).from_([])

    def test_says_what_is_wrong_with_vertices_and_faces(self):
        V, F = mesh().vertices, mesh().faces
        for call in (lambda v, f: mq.unwrap(v, f), lambda v, f: mq.Mesh(v, f)):
            with self.assertRaisesRegex(mq.InvalidInput, r"^vertices: found an array of shape \(\d+, 2\), wanted"):
                call(V[:, :2], F)
            with self.assertRaisesRegex(mq.InvalidInput, r"^faces: .*, 4\), wanted \(faces, 3\): make two triangles"):
                call(V, F[:, [0, 1, 2, 2]])
            with self.assertRaisesRegex(TypeError, "^faces: found an array of float64, wanted whole numbers"):
                call(V, F + 0.5)

    def test_takes_rows_of_an_array_as_places(self):
        places = [tuple(float(x) for x in mesh().vertices[k]) for k in (0, 3)]
        one = mq.geodesic(mesh(), np.zeros((32, 32, 3), np.uint8), from_=places).picture
        np.testing.assert_array_equal(one, mq.geodesic(mesh(), np.zeros((32, 32, 3), np.uint8),
                                                       from_=np.array(places)).picture)

    def test_models_in_one_folder_have_pictures_of_their_own(self):
        with tempfile.TemporaryDirectory() as place:
            for name in ("a", "b"):
                mq.filter(sample() / "bust.obj", arrays()[3], beta=2, output=f"{place}/{name}.obj")
            self.assertEqual(sorted(os.listdir(place)), ["a.mtl", "a.obj", "a.png", "b.mtl", "b.obj", "b.png"])
            with self.assertRaisesRegex(mq.InvalidInput, "^texture: found an array"):
                mq.filter(sample() / "bust.obj", np.zeros((2, 2, 2, 2), np.uint8), beta=2, output=f"{place}/c.obj")

    def test_names_in_other_encodings(self):
        with tempfile.TemporaryDirectory() as place:
            path = pathlib.Path(place) / "fan.obj"
            (pathlib.Path(place) / "fan.mtl").write_bytes(b"newmtl m\nmap_Kd t\xfcr.png\n")
            path.write_text("mtllib fan.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
                            "f 1/1 2/2 3/3\n")
            with self.assertRaisesRegex(mq.IoError, r"names the picture .*t\\+xfcr.png"):
                mq.filter(path, beta=2)

    def test_warnings_and_log(self):
        vertices, faces, uvs, picture = arrays()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mq.filter(vertices, np.concatenate([faces, faces[:1]]), np.concatenate([uvs, uvs[:1]]), picture, beta=2)
        self.assertTrue(any(issubclass(one.category, mq.Warning) for one in caught))
        self.assertTrue(all(one.filename == __file__ for one in caught if issubclass(one.category, mq.Warning)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with self.assertRaises(mq.Warning):
                mq.filter(vertices, np.concatenate([faces, faces[:1]]), np.concatenate([uvs, uvs[:1]]), picture, beta=2)
        with self.assertLogs("marquetry", logging.INFO) as log:
            mq.render(vertices, faces, uvs, size=32)
        self.assertNotIn("memory:", "".join(log.output))

    def test_progress(self):
        events = []
        mq.filter(mesh("bust", 256), beta=3, progress=lambda fraction, step: events.append((fraction, step)))
        self.assertTrue(events)
        self.assertEqual([one for one, _ in events], sorted(one for one, _ in events))
        self.assertEqual(events[-1], (1.0, "done"))
        with self.assertRaisesRegex(RuntimeError, "enough"):
            def stop(fraction, step):
                raise RuntimeError("enough")
            mq.react(mesh("bust", 256), time=100000, progress=stop)

    def test_progress_as_a_bar(self):
        try:
            import tqdm  # noqa: F401
        except ImportError:
            self.skipTest("tqdm is not installed")
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            mq.filter(mesh("bust", 128), beta=3, progress=True)
        self.assertRegex(said.getvalue(), r"done 100%\|[█#]+\|")
        self.assertTrue(said.getvalue().endswith("\n"), "the bar is closed")
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            mq.TexelSpace(mesh("bust", 128), progress=True)
        self.assertRegex(said.getvalue(), r"done 100%\|[█#]+\|")
        said = io.StringIO()
        with contextlib.redirect_stderr(said), self.assertRaises(mq.InvalidInput):
            mq.unwrap(np.zeros((3, 3)), np.array([[0, 1, 2]]), progress=True)
        self.assertNotIn("100%", said.getvalue())

    def test_a_bar_without_tqdm(self):
        with unittest.mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}):
            with self.assertRaisesRegex(ImportError, "python3-tqdm"):
                mq.filter(mesh("bust", 128), beta=3, progress=True)
            with self.assertRaisesRegex(ImportError, "python3-tqdm"):
                mq.ImageSpace(9, 9).system(1.0, 1.0, progress=True)
            mq.ImageSpace(9, 9, progress=False)

    def test_progress_of_spaces(self):
        events = []

        def hear(fraction, step):
            events.append((fraction, step))
        space = mq.TexelSpace(mesh("bust", 128), progress=hear)
        self.assertEqual(events[-1], (1.0, "done"))
        del events[:]
        mq.ScreenedPoisson(space, 0.1, progress=hear).solve(np.ones(space.size), 0.0, progress=hear)
        self.assertEqual([one for one in events if one[0] == 1][-1], (1.0, "done"))

    def test_pictures_of_other_kinds_are_refused_with_those_that_are_taken(self):
        vertices, faces, uvs, picture = arrays("bust", 128)
        for kind, hint in ((np.int64, "astype.np.uint8."), (np.int16, "astype.np.uint8."), (np.uint32, "astype")):
            with self.assertRaisesRegex(TypeError, rf"found an array of {np.dtype(kind)}, wanted uint8.*uint16.*{hint}"):
                mq.filter(vertices, faces, uvs, picture.astype(kind), beta=3)
        with self.assertRaisesRegex(TypeError, "astype.np.uint16. makes one of it$"):
            mq.filter(vertices, faces, uvs, picture.astype(np.int32) * 257, beta=3)
        for other in (picture.astype(np.int64) - 1000, picture.astype(np.int64) * 1000, picture.astype(complex)):
            with self.assertRaisesRegex(TypeError, "floats .0 to 1.$"):
                mq.filter(vertices, faces, uvs, other, beta=3)

    def test_messages_name_arguments_and_no_files_that_are_not_there(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with self.assertRaisesRegex(mq.InvalidInput, "^mesh: the surface has no area"):
                mq.unwrap(np.zeros((3, 3)), np.array([[0, 1, 2]]))
        vertices, faces, uvs, _ = arrays("bust", 128)
        with self.assertRaisesRegex(mq.InvalidInput, "^mesh: texture 0 has no picture"):
            mq.seams(vertices, faces, uvs)
        path = pathlib.Path(folder()) / "mesh.ply"
        path.write_text("ply\nformat ascii 1.0\n")
        with self.assertRaisesRegex(mq.IoError, "mesh.ply"):
            mq.seams(path)

    def test_ctrl_c(self):
        started = time.monotonic()
        timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            mq.react(mesh("bust", 256), time=1000000)
        self.assertLess(time.monotonic() - started, 20)

    def test_sequences_have_no_alpha(self):
        vertices, faces = arrays()[:2]
        colours = np.random.default_rng(3).integers(0, 255, (len(vertices), 4), np.uint8)
        made = []
        for count in (3, 4):
            frames = [mq.Mesh(vertices, faces, colors=colours[:, :count])] * 2
            made.append(mq.track(frames, output=folder() / f"of_{count}.evolving"))
        self.assertEqual(*(result.files[1].read_bytes() for result in made))
        with self.assertRaisesRegex(mq.InvalidInput, r"sequence\[0\]: found colors of shape .*, 2\)"):
            mq.track([mq.Mesh(vertices, faces, colors=colours[:, :2])], output=folder() / "of_2.evolving")

    def test_what_is_safe_after_ctrl_c(self):
        vertices, faces = arrays()[:2]
        frames = [(vertices + [0.01 * k, 0, 0], faces) for k in range(6)]
        made = folder() / "stopped.evolving"

        def stop(fraction, step):
            if made.exists() and made.read_text().count('"frame"') >= 2:
                raise KeyboardInterrupt
        with self.assertRaisesRegex(KeyboardInterrupt, r"stopped\.evolving has \d of 6 frames, and resume goes on"):
            mq.track(frames, output=made, progress=stop)
        report = mq.track(frames, output=made, resume=True).report
        self.assertEqual([one["frame"] for one in report["result"]["frames"]], list(range(6)))

    def test_none_is_no_model(self):
        with self.assertRaisesRegex(TypeError, "^mesh: found None, wanted the model"):
            mq.inspect(None)

    def test_frames_want_a_place_for_each(self):
        with self.assertRaisesRegex(mq.InvalidInput, "^output: found none.*out_%04d.png"):
            mq.filter(mesh(), frames=(1, 3), beta=2)

    def test_other_threads_go_on(self):
        count = [0]
        done = threading.Event()

        def tick():
            while not done.is_set():
                count[0] += 1
                time.sleep(0.001)
        thread = threading.Thread(target=tick)
        thread.start()
        mq.filter(mesh("bust", 512), beta=3)
        done.set()
        thread.join()
        self.assertGreater(count[0], 20)

    def test_a_report_repeats_a_run(self):
        report = folder() / "report.json"
        first = mq.filter(mesh(), beta=3.5, length="2tx", report=report)
        self.assertEqual(json.loads(report.read_text())["options"]["beta"], 3.5)
        self.assertEqual(first.report["options"]["length"], "2tx")


if __name__ == "__main__":
    unittest.main()
