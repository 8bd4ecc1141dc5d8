"""Wrong shapes, kinds, values and steps: an exception each, and never a crash."""
import os
import unittest
import warnings

import numpy as np

import marquetry as mq

VERBS = 2
COUNT = int(os.environ.get("MARQUETRY_RANDOM_CALLS", "1000"))


def grid(side=4):
    """A flat square of side² quads, one chart."""
    x, y = np.meshgrid(np.arange(side + 1), np.arange(side + 1))
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1).astype(float)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    quads = np.stack([corner, corner + 1, corner + side + 2, corner + side + 1], 1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    uvs = vertices[faces][:, :, :2] * 0.8 / side + 0.1
    return vertices, faces, uvs


class Spoiler:
    """Makes one thing of an array wrong."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)

    def spoil(self, array):
        ways = [self.cut, self.more_axes, self.empty, self.other_kind, self.nothing, self.transposed]
        if array.dtype.kind == "f":
            ways += [self.not_finite] * 3
        elif array.dtype.kind == "i":
            ways += [self.beyond] * 3
        return ways[self.random.integers(len(ways))](array)

    def cut(self, array):
        axis = self.random.integers(array.ndim)
        return np.take(array, np.arange(max(0, array.shape[axis] - 1)), axis)

    def more_axes(self, array):
        return array[..., None] if self.random.integers(2) else array[None]

    def empty(self, array):
        shape = list(array.shape)
        shape[self.random.integers(array.ndim)] = 0
        return np.zeros(shape, array.dtype)

    def other_kind(self, array):
        kinds = [complex, "U3", object, "M8[s]"] + ([float] if array.dtype.kind == "i" else [])
        kind = kinds[self.random.integers(len(kinds))]
        if kind == "M8[s]":
            return np.zeros(array.shape, kind)
        return np.full(array.shape, None) if kind is object else array.astype(kind)

    def nothing(self, array):
        return [None, "text", 3.5, {}, object(), [[]], -1][self.random.integers(7)]

    def transposed(self, array):
        return array.T if array.ndim > 1 and array.shape[0] != array.shape[1] else array[None]

    def not_finite(self, array):
        made = array.copy()
        made.flat[self.random.integers(made.size)] = [np.nan, np.inf, -np.inf][self.random.integers(3)]
        return made

    def beyond(self, array):
        made = array.astype(np.int64)
        made.flat[self.random.integers(made.size)] = [-1, 10 ** 6, 2 ** 40, -2 ** 63][self.random.integers(4)]
        return made


class RandomCalls(unittest.TestCase):
    def setUp(self):
        self.vertices, self.faces, self.uvs = grid()
        self.picture = np.random.default_rng(7).uniform(size=(16, 16, 3)).astype(np.float32)
        self.space = mq.TexelSpace((self.vertices, self.faces, self.uvs), 16)
        self.points = mq.VertexSpace((self.vertices, self.faces))
        self.equation = mq.ScreenedPoisson(self.space, 0.1)

    def calls(self):
        """Functions of arrays, each with good ones; VERBS of them, and then those of spaces."""
        psi = self.space.gather(self.picture)
        faces, weights = np.array([0, 1]), np.full((2, 3), 1 / 3)
        ones = np.ones(self.space.element_count)
        A = self.space.system(1.0, 1.0)
        solver = mq.Solver(A, self.space)

        def mesh(vertices, corners, uvs):
            return mq.Mesh(vertices, corners, uvs)
        return [
            (lambda v, f, u, p: mq.filter(mesh(v, f, u), p, beta=2),
             [self.vertices, self.faces, self.uvs, self.picture]),
            (lambda v, f, u, p: mq.seams(mesh(v, f, u), p), [self.vertices, self.faces, self.uvs, self.picture]),
            (lambda v, f, u: mq.TexelSpace(mesh(v, f, u), 16), [self.vertices, self.faces, self.uvs]),
            (lambda v, f: mq.VertexSpace((v, f)), [self.vertices, self.faces]),
            (lambda p: self.space.gather(p), [self.picture]),
            (lambda s, p: self.space.scatter(s, p), [psi, self.picture]),
            (lambda s: self.space.stiffness_times(s), [psi]),
            (lambda s: self.space.gradient_norms(s), [psi]),
            (lambda s, c: self.space.weighted_stiffness_times(s, c), [psi, ones]),
            (lambda c: self.space.weighted_system(1.0, 1.0, c), [ones]),
            (lambda f, b: self.space.basis_at(f, b), [faces, weights]),
            (lambda f, b: self.points.basis_at(f, b), [faces, weights]),
            (lambda s: self.equation.solve(s, 2.0), [psi]),
            (lambda s, b: self.equation.solve(s, b), [psi, np.ones(self.space.size)]),
            (lambda s, m: self.equation.solve_towards(s, m), [psi, psi]),
            (lambda s: solver.solve(s), [psi]),
            (lambda v: self.points.gather(v), [np.ones((len(self.vertices), 2))]),
            (lambda s: mq.ScreenedPoisson(self.space, 0.1, screen=s), [np.ones(self.space.size)]),
            (lambda s, w: mq.GeodesicDistance(self.points).from_(s, w), [np.array([0, 3]), np.array([0.0, 0.1])]),
        ]

    def test_wrong_arrays_are_refused(self):
        calls = self.calls()
        for function, good in calls:
            function(*good)
        accepted = []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for seed in range(COUNT):
                spoiler = Spoiler(seed)
                at = int(spoiler.random.integers(len(calls)))
                function, good = calls[at]
                place = int(spoiler.random.integers(len(good)))
                bad = spoiler.spoil(good[place])
                arguments = [bad if k == place else one for k, one in enumerate(good)]
                try:
                    function(*arguments)
                except (mq.Error, TypeError, ValueError):
                    continue
                if at < VERBS and self.is_picture(bad, good[place]):
                    continue  # of any size
                if not self.is_right_as_well(bad, good[place]):
                    accepted.append((seed, at, place, getattr(bad, "shape", bad), getattr(bad, "dtype", type(bad))))
        self.assertEqual(accepted, [])

    @staticmethod
    def is_picture(bad, good):
        return (isinstance(bad, np.ndarray) and bad.dtype == good.dtype == np.float32 and bad.ndim in (2, 3)
                and bad.size > 0 and np.isfinite(bad).all())

    @staticmethod
    def is_right_as_well(bad, good):
        """What differs from what was given, and is as good: fewer channels or faces, a number for each unknown's."""
        if bad is None or isinstance(bad, (int, float)):
            return good.ndim == 1 or good.shape[1:] == (3, 2)  # a factor for all, or what is optional
        if not isinstance(bad, np.ndarray) or bad.dtype != good.dtype or not bad.size or not np.isfinite(bad).all():
            return False
        if good.dtype.kind == "i":
            return bad.shape[1:] == good.shape[1:] and bad.min() >= 0 and bad.max() <= good.max()
        axes = 2 if good.dtype == np.float32 else 1
        return bad.shape[:axes] == good.shape[:axes] and bad.ndim in (axes, axes + 1)

    def test_arrays_with_steps_are_taken(self):
        psi = self.space.gather(self.picture)
        wide = np.repeat(psi, 2, axis=1)[:, ::2]
        np.testing.assert_array_equal(self.space.stiffness_times(wide), self.space.stiffness_times(psi))
        backward = np.ascontiguousarray(psi[::-1])[::-1]
        np.testing.assert_array_equal(self.space.stiffness_times(backward), self.space.stiffness_times(psi))

    def test_columns_of_records_are_taken(self):
        """Whose values begin at any byte."""
        colours = np.random.default_rng(9).integers(0, 65535, (len(self.vertices), 3), np.uint16)
        records = np.zeros(len(self.vertices), [("kind", "u1"), ("position", "f8", 3), ("colour", "u2", 3)])
        records["position"], records["colour"] = self.vertices, colours
        corners = np.zeros(len(self.faces), [("kind", "u1"), ("corners", "i4", 3)])
        corners["corners"] = self.faces
        pixels = np.zeros(self.picture.shape[:2], [("kind", "u1"), ("values", "f4", 3)])
        pixels["values"] = self.picture
        packed = mq.Mesh(records["position"], corners["corners"], self.uvs, colors=records["colour"])
        plain = mq.Mesh(self.vertices, self.faces, self.uvs, colors=colours)
        np.testing.assert_array_equal(mq.filter(packed, beta=2, vertices=True).mesh.colors,
                                      mq.filter(plain, beta=2, vertices=True).mesh.colors)
        np.testing.assert_array_equal(mq.filter(packed, pixels["values"], beta=2).picture,
                                      mq.filter(plain, self.picture, beta=2).picture)
        space = mq.TexelSpace(packed, 16)
        np.testing.assert_array_equal(space.gather(pixels["values"]), self.space.gather(self.picture))

    def test_wrong_numbers_are_refused(self):
        nan, infinite = float("nan"), float("inf")
        for wrong in (nan, -1.0, "far", None, 1j):
            with self.subTest(wrong), self.assertRaises((mq.Error, TypeError, ValueError)):
                mq.ScreenedPoisson(self.space, wrong)
        for call in (lambda: mq.TexelSpace((self.vertices, self.faces, self.uvs), 0),
                     lambda: mq.TexelSpace((self.vertices, self.faces, self.uvs), -5),
                     lambda: mq.TexelSpace((self.vertices, self.faces, self.uvs), 10 ** 9),
                     lambda: mq.TexelSpace((self.vertices, self.faces, self.uvs), 16, weld=nan),
                     lambda: mq.TexelSpace((self.vertices, self.faces, self.uvs), 16, weld="nearly"),
                     lambda: mq.ImageSpace(0, 5), lambda: mq.ImageSpace(10 ** 9, 1),
                     lambda: self.space.system(nan, 1.0), lambda: self.space.weight("many"),
                     lambda: mq.GeodesicDistance(self.space, time=nan),
                     lambda: mq.ScreenedPoisson(self.space, 1.0, tolerance=nan),
                     lambda: mq.ScreenedPoisson(self.space, 1.0, solver="best"),
                     lambda: mq.Solver(np.eye(3)), lambda: self.equation.solve(np.ones(self.space.size), infinite)):
            with self.assertRaises((mq.Error, TypeError, ValueError)):
                call()


if __name__ == "__main__":
    unittest.main()
