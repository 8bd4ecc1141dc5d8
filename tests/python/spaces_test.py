"""Matrices and prepared equations."""
import gc
import unittest

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

import marquetry as mq
from models import arrays, mesh


def spaces():
    model = mesh()
    return {"texels": mq.TexelSpace(model), "vertices": mq.VertexSpace(model), "pixels": mq.ImageSpace(40, 30)}


class Matrices(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.spaces = spaces()

    def test_stiffness_vanishes_on_constants(self):
        for name, space in self.spaces.items():
            with self.subTest(name):
                S = space.stiffness()
                self.assertLessEqual(np.abs(S @ np.ones(space.size)).max(), 1e-9 * np.abs(S.data).max())

    def test_mass_sums_to_the_area(self):
        for name, space in self.spaces.items():
            with self.subTest(name):
                M = space.mass()
                self.assertAlmostEqual(M.sum() / space.area, 1, places=10)
                np.testing.assert_allclose(space.lumped_mass(), M @ np.ones(space.size), rtol=0,
                                           atol=1e-12 * np.abs(M.data).max())

    def test_stiffness_is_the_divergence_of_the_gradient(self):
        for name, space in self.spaces.items():
            with self.subTest(name):
                difference = abs(space.divergence() @ space.gradient() - space.stiffness())
                self.assertLessEqual(difference.max(), 1e-10 * abs(space.stiffness()).max())

    def test_products_need_no_matrix(self):
        generator = np.random.default_rng(1)
        for name, space in self.spaces.items():
            with self.subTest(name):
                psi = generator.normal(size=(space.size, 3))
                S = space.stiffness()
                np.testing.assert_allclose(space.stiffness_times(psi), S @ psi, atol=1e-9 * np.abs(S @ psi).max())
                ones = np.ones(space.element_count)
                np.testing.assert_allclose(space.weighted_stiffness_times(psi, ones), S @ psi,
                                           atol=1e-6 * np.abs(S @ psi).max())
                self.assertEqual(space.gradient_norms(psi).shape, (space.element_count,))

    def test_basis_functions_sum_to_one_and_interpolate_positions(self):
        generator = np.random.default_rng(2)
        for name in ("texels", "vertices"):
            with self.subTest(name):
                space = self.spaces[name]
                faces = generator.integers(0, len(space.mesh.faces), 50)
                weights = generator.dirichlet((1, 1, 1), 50)
                B = space.basis_at(faces, weights)
                self.assertEqual(B.shape, (50, space.size))
                np.testing.assert_allclose(B @ np.ones(space.size), 1, atol=1e-10)
                if name == "vertices":
                    corners = space.mesh.vertices[space.mesh.faces[faces]]
                    wanted = np.einsum("pk,pkx->px", weights, corners)
                    np.testing.assert_allclose(B @ space.positions(), wanted, atol=1e-12)

    def test_arrays_are_the_librarys_own_and_outlive_the_space(self):
        space = mq.ImageSpace(30, 20)
        M = space.mass()
        self.assertFalse(M.data.flags.owndata)
        self.assertFalse(M.indices.flags.owndata)
        before = M.sum()
        del space
        gc.collect()
        self.assertEqual(M.sum(), before)

    def test_gather_and_scatter_give_back_pictures(self):
        *_, picture = arrays()
        space = self.spaces["texels"]
        signal = space.gather(picture)
        self.assertEqual(signal.shape, (space.size, 3))
        np.testing.assert_array_equal(space.scatter(signal, picture), picture)
        texture, x, y = space.texels().T
        np.testing.assert_allclose(signal, picture[y, x] / np.float32(255), atol=1e-7)
        changed = space.scatter(1 - signal, picture)
        inside = np.zeros(picture.shape[:2], bool)
        inside[y, x] = True
        np.testing.assert_array_equal(changed[~inside], picture[~inside])
        np.testing.assert_array_equal(changed[inside], 255 - picture[inside])
        self.assertEqual(set(texture), {0})

    def test_vertices_that_files_split_are_one_unknown(self):
        vertices, faces, _, _ = arrays()
        split = mq.Mesh(vertices[faces].reshape(-1, 3), np.arange(3 * len(faces), dtype=np.int32).reshape(-1, 3))
        space, apart = mq.VertexSpace(split), mq.VertexSpace(split, weld="none")
        self.assertEqual(space.size, mq.VertexSpace((vertices, faces)).size)
        self.assertEqual(apart.size, 3 * len(faces))
        values = np.arange(len(split.vertices), dtype=float)
        back = space.scatter(space.gather(values), values)
        self.assertEqual(len(set(back)), space.size)


class Equations(unittest.TestCase):
    def test_a_filter_by_scipy_equals_ours(self):
        model = mesh("bust", 64)
        for name, space in {"texels": mq.TexelSpace(model), "vertices": mq.VertexSpace(model),
                            "pixels": mq.ImageSpace(48, 32)}.items():
            with self.subTest(name):
                psi = np.random.default_rng(3).uniform(size=(space.size, 2))
                w, beta = space.weight("1%"), 2.5
                ours = mq.ScreenedPoisson(space, w, solver="direct").solve(psi, beta)
                A, S = space.regularised_system(1, w), space.stiffness()
                theirs = psi + scipy.sparse.linalg.spsolve(A.tocsc(), w * (beta - 1) * (S @ psi))
                self.assertLessEqual(np.abs(ours - theirs).max(), 1e-9 * np.abs(theirs).max())
                if name != "texels":  # of which some hardly meet the surface
                    self.assertLessEqual(abs(A - (space.mass() + w * S)).max(), 1e-14 * abs(A).max())

    def test_a_factor_of_one_changes_nothing(self):
        space = mq.ImageSpace(20, 20)
        psi = np.random.default_rng(4).uniform(size=space.size)
        equation = mq.ScreenedPoisson(space, 3.0)
        np.testing.assert_array_equal(equation.solve(psi, 1.0), psi)
        np.testing.assert_allclose(equation.solve(psi, np.full(space.size, 2.0)), equation.solve(psi, 2.0), atol=1e-12)
        self.assertTrue(equation.report["converged"])
        equation.set_weight(5.0)
        self.assertEqual(equation.weight, 5.0)
        np.testing.assert_allclose(equation.solve_towards(psi, 2 * space.stiffness_times(psi)),
                                   equation.solve(psi, 2.0), atol=1e-9)

    def test_distances_on_a_flat_picture(self):
        space = mq.ImageSpace(61, 41)
        distance = mq.GeodesicDistance(space).from_(20 * 61 + 30)
        x, y = np.meshgrid(np.arange(61) - 30, np.arange(41) - 20)
        wanted = np.hypot(x, y).ravel()
        far = wanted > 3
        self.assertLess(np.abs(distance - wanted)[far].max(), 0.06 * wanted.max())

    def test_solvers_of_matrices(self):
        space = mq.ImageSpace(30, 30)
        A = space.system(1.0, 4.0)
        b = np.random.default_rng(5).normal(size=(space.size, 3))
        for solver in (mq.Solver(A), space.solver(1.0, 4.0, tolerance=1e-12), mq.Solver(A, space, "multigrid", 1e-12)):
            np.testing.assert_allclose(A @ solver.solve(b), b, atol=1e-8)
        with self.assertRaises(mq.SolverError):
            mq.Solver(scipy.sparse.csr_matrix(-np.eye(3)))
        np.testing.assert_array_equal(mq.Solver(A).solve(np.zeros(space.size)), 0)
        with self.assertRaisesRegex(mq.SolverError, "^matrix: is (singular|not positive)|positive definite"):
            mq.Solver(space.stiffness()).solve(np.ones(space.size))

    def test_matrices_whose_arrays_were_spoilt_are_refused(self):
        for name, wrong in (("indptr", [0, 1, 300, 3, 4]), ("indptr", [0, 1, -2, 3, 4]), ("indptr", [0, 4, 2, 3, 4]),
                            ("indptr", [1, 2, 3, 4, 4]), ("indices", [0, 1, 2, 4]), ("indices", [0, -1, 2, 3])):
            for kind in (scipy.sparse.csr_matrix, scipy.sparse.csc_matrix):
                A = kind(np.eye(4))
                getattr(A, name)[:] = wrong
                with self.subTest(name=name, wrong=wrong, kind=kind), self.assertRaisesRegex(mq.InvalidInput, "^matrix: "):
                    mq.Solver(A)
        for name, wrong in (("row", [0, 1, 4, 3]), ("row", [0, 1, -1, 3]), ("col", [0, 1, 2, 1 << 30]), ("data", [1.0, 1.0])):
            A = scipy.sparse.coo_matrix(np.eye(4))
            setattr(A, name, np.array(wrong, dtype=getattr(A, name).dtype))
            with self.subTest(name=name, wrong=wrong), self.assertRaisesRegex(mq.InvalidInput, "^matrix: "):
                mq.Solver(A)


if __name__ == "__main__":
    unittest.main()
