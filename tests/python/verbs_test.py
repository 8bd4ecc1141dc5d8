"""Every verb in Python gives the program's bytes."""
import json
import pathlib
import shutil
import unittest

import numpy as np

import marquetry as mq
from marquetry import _verbs
from models import folder, program, sample


def same_json(text):
    """What a report says but for time and memory."""
    def plain(value):
        if isinstance(value, dict):
            return {name: plain(one) for name, one in value.items()
                    if not name.endswith("seconds") and name != "peak_bytes"}
        return [plain(one) for one in value] if isinstance(value, list) else value
    return plain(json.loads(text))


def contents(place):
    """The bytes of all files below a folder, by name."""
    found = {}
    for path in sorted(pathlib.Path(place).rglob("*")):
        if path.is_file():
            data: object = path.read_bytes()
            if path.suffix == ".json":
                data = same_json(path.read_text())
            elif path.suffix == ".evolving":  # an object a line
                data = [same_json(line) for line in path.read_text().splitlines()]
            found[str(path.relative_to(place))] = data
    return found


class Program(unittest.TestCase):
    """One test for each verb; `test_all_verbs_are_here` counts them."""

    def compare(self, verb, positional, options, outputs=("output",)):
        """Runs one after the other in the same folder, below which `outputs` are names."""
        done = {}
        place = folder() / verb
        for who in ("program", "python"):
            shutil.rmtree(place, ignore_errors=True)
            place.mkdir(parents=True)
            options_here = {name: (str(place) + "/" + value if name in outputs else value)
                            for name, value in options.items()}
            if who == "python":
                report = getattr(mq, verb)(*positional, **options_here).report
            else:
                words = [verb, *positional]
                for name, value in options_here.items():
                    flag = "--" + name.rstrip("_").replace("_", "-")
                    words += [flag] if value is True else [f"{flag}={value}"]
                report = json.loads(program(*words, "--json"))
            done[who] = (same_json(json.dumps(report)), contents(place))
        self.assertEqual(done["program"][0], done["python"][0])
        self.assertEqual(done["program"][1].keys(), done["python"][1].keys())
        for name, data in done["program"][1].items():
            self.assertEqual(data, done["python"][1][name], name)
        return done["python"][1]

    @classmethod
    def setUpClass(cls):
        made = sample()
        cls.model, cls.picture = str(made / "bust.obj"), str(made / "bust.png")
        cls.other = str(sample("bust_4") / "bust_4.obj")

    def model_to_picture(self, verb, **options):
        made = self.compare(verb, [self.model, self.picture], {"output": "out.png", **options})
        self.assertIn("out.png", made)

    def test_filter(self):
        self.model_to_picture("filter", beta=3.0, length="3tx")

    def test_denoise(self):
        self.model_to_picture("denoise", edge=0.1)

    def test_seams(self):
        self.model_to_picture("seams")

    def test_fill(self):
        self.model_to_picture("fill", distance=4.0)

    def test_mask(self):
        self.model_to_picture("mask", what="chart")

    def test_geodesic(self):
        self.model_to_picture("geodesic", from_="texel,64,64")

    def test_lic(self):
        self.model_to_picture("lic", kappa=20.0)

    def test_react(self):
        self.model_to_picture("react", time=20.0, scale="5%")

    def test_shock(self):
        self.model_to_picture("shock", time=2.0)

    def test_stitch(self):
        self.model_to_picture("stitch", labels=self.picture)

    def test_render(self):
        self.model_to_picture("render", size="96", seams=True)

    def test_inspect(self):
        self.compare("inspect", [self.model, self.picture], {})

    def test_spectrum(self):
        self.compare("spectrum", [self.model], {"output": "out/", "count": 2})

    def test_fields(self):
        self.compare("fields", [self.model], {"output": "out/", "field": "min-curvature"})

    def test_unwrap(self):
        self.compare("unwrap", [self.model], {"output": "out.obj", "size": 256})

    def test_bake(self):
        self.compare("bake", [self.model, self.other, self.picture], {"output": "out.png", "size": 64})

    def test_remesh(self):
        self.compare("remesh", [self.model, self.other], {"output": "out.ply", "record": "record.json"},
                     ("output", "record"))

    def test_sample(self):
        self.compare("sample", ["cube"], {"output": "out/", "size": 32})

    def test_flow_and_interpolate(self):
        second = str(folder() / "second.png")
        program("filter", self.picture, "-o", second, "--beta", 0, "--length", "3tx")
        made = self.compare("flow", [self.picture, second], {"output": "out/"})
        self.assertGreater(len(made), 4)
        self.compare("interpolate", [self.picture, second], {"output": "out.png", "time": 0.25})

    def test_cameras(self):
        made = folder() / "photographs"
        made.mkdir(exist_ok=True)
        program("render", self.model, "--size", "64", "-o", made / "one.png", "--cameras", made / "one.json")
        self.compare("cameras", [str(made / "one.json")],
                     {"output": "cameras.json", "mesh": self.model, "picture": "around.png", "size": "64"},
                     ("output", "picture"))

    def test_texture(self):
        made = folder() / "of_photographs"
        made.mkdir(exist_ok=True)
        program("render", self.model, "--size", "64", "-o", made / "one.png", "--cameras", made / "one.json")
        self.compare("texture", [self.model],
                     {"cameras": str(made / "one.json"), "output": "out.png", "picture": "chosen.png"},
                     ("output", "picture"))

    def test_check_says_what_it_found(self):
        self.compare("check", [self.model, self.picture], {})

    def test_sequences(self):
        frames = folder() / "frames"
        program("sample", "merging", "-o", frames / "frame_%04d.ply", "--frames", "0-3", "--triangles", 500)
        sequence = str(frames / "frame_%04d.ply")
        self.compare("track", [sequence], {"output": "out.evolving", "frames": "0-2"})
        self.compare("evolve", [sequence], {"output": "out.evolving", "frames": "0-2", "size": 256})
        stored = str(folder() / "evolve" / "out.evolving")
        self.compare("export", [stored], {"output": "frame_%04d.ply"})
        self.compare("play", [stored], {"output": "page/"})
        self.frames_of_all_kinds(stored)
        textures = folder() / "textures"
        textures.mkdir(exist_ok=True)
        program("export", stored, "-o", textures / "texture_%04d.png", "--from", sequence, "--size", 128)
        self.compare("relight", [stored, str(textures / "texture_%04d.png")], {"output": "lit_%04d.png"})

    def frames_of_all_kinds(self, stored):
        def made(frames):
            report = mq.play(stored, output=str(folder() / "some"), overwrite=True, frames=frames).report
            return report["options"]["frames"], report["result"]["frames"]

        self.assertEqual(made(range(1, 3)), ("1-2", 2))
        self.assertEqual(made(range(0, 3, 2)), ("0-2x2", 2))
        self.assertEqual(made((0, 2)), ("0-2", 3))
        self.assertEqual(made([0, 2]), ("0-2x2", 2))
        self.assertEqual(made(np.array([1])), ("1", 1))
        self.assertEqual(made(iter([0, 1, 2])), ("0-2", 3))
        self.assertEqual(made(1), ("1", 1))
        self.assertEqual(made("1-2"), ("1-2", 2))
        for wrong in ([0, 1, 3], [], [2, 1], (2, 0), [-1, 0], range(0)):
            with self.assertRaisesRegex(mq.InvalidInput, r"^frames: found .*range\(1, 101, 2\)"):
                made(wrong)
        with self.assertRaisesRegex(TypeError, "^frames: found .*whole numbers"):
            made([0.5, 1.5])

    def test_all_verbs_are_here(self):
        covered = {"track", "evolve", "export", "play", "relight", "flow", "interpolate", "check"}
        covered |= {name[5:] for name in dir(self) if name.startswith("test_")}
        self.assertEqual(set(_verbs.__all__) - covered, set())


if __name__ == "__main__":
    unittest.main()
