"""Arguments that would be misread are refused, with what to do instead."""
import unittest

import numpy as np

import marquetry as mq
from models import folder
from random_test import grid


class Refusals(unittest.TestCase):
    def setUp(self):
        self.vertices, self.faces, self.uvs = grid()
        self.mesh = mq.Mesh(self.vertices, self.faces, self.uvs)
        self.picture = np.random.default_rng(3).uniform(size=(16, 16, 3)).astype(np.float32)

    def refused(self, call, *words):
        with self.assertRaises(mq.InvalidInput) as caught:
            call()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_slots_that_no_material_has(self):
        for slot in ("bogus", "base-color2", "Texture"):
            with self.subTest(slot):
                self.refused(lambda: mq.filter(self.mesh, self.picture, beta=2, slot=slot), "mesh: slot", slot)
        self.refused(lambda: mq.filter(self.mesh, self.picture, beta=2, slot="oclusion"), "did you mean 'occlusion'")
        self.refused(lambda: mq.bake(self.mesh, self.mesh, self.picture, size=16, slot="bogus"), "slot", "bogus")

    def test_slots_that_materials_have_are_taken(self):
        for slot in ("albedo", "base_color", "map_Ks", "clearcoatNormalTexture", "sheen-color", "orm"):
            with self.subTest(slot):
                made = mq.filter(self.mesh, self.picture, beta=2, slot=slot).picture
                self.assertEqual(made.shape, self.picture.shape)

    def test_layers_of_arrays(self):
        self.refused(lambda: mq.filter(self.mesh, self.picture, beta=2, layer="diffuse"), "has no layer", "leave layer")

    def test_masked_arrays(self):
        hidden = np.ma.masked_array(self.picture, self.picture > 0.9)
        space = mq.TexelSpace(self.mesh, 16)
        psi = np.ma.masked_less(space.gather(self.picture), 0.1)
        points = np.ma.masked_equal(self.vertices, 2.0)
        corners = np.ma.masked_equal(self.faces, 0)
        calls = {"texture": lambda: mq.filter(self.mesh, hidden, beta=2),
                 "vertices": lambda: mq.filter(points, self.faces, self.uvs, self.picture, beta=2),
                 "faces": lambda: mq.VertexSpace((self.vertices, corners)),
                 "pictures": lambda: space.gather(hidden), "psi": lambda: space.stiffness_times(psi),
                 "signal": lambda: space.scatter(psi, self.picture),
                 "unknowns": lambda: mq.GeodesicDistance(space).from_(np.ma.masked_equal([0, 3], 3))}
        for name, call in calls.items():
            with self.subTest(name):
                self.refused(call, name + ": found", "masked", ".filled(")

    def test_masked_arrays_that_hide_nothing_are_arrays(self):
        plain = mq.filter(self.mesh, self.picture, beta=2).picture
        masked = mq.filter(self.mesh, np.ma.masked_array(self.picture, False), beta=2).picture
        np.testing.assert_array_equal(masked, plain)

    def test_standard_streams(self):
        for words, name in (((self.mesh, "-"), "texture"), (("-",), "mesh"), (("ply:-", self.picture), "mesh")):
            with self.subTest(words=words):
                self.refused(lambda: mq.filter(*words, beta=2), name + ":", "standard input or output", "name a file")
        for options in ({"output": "-"}, {"output": "png:-"}, {"report": "-"}, {"config": "-"}):
            with self.subTest(options):
                self.refused(lambda: mq.filter(self.mesh, self.picture, beta=2, **options), *options, "name a file")

    def test_standard_streams_in_a_configuration(self):
        config = folder() / "streams.json"
        config.write_text('{"report": "-"}')
        self.refused(lambda: mq.filter(self.mesh, self.picture, beta=2, config=config), "report:", "name a file")


if __name__ == "__main__":
    unittest.main()
