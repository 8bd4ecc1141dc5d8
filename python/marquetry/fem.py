"""Signal spaces: a basis of functions on a surface, and the matrices of finite elements on it.

    M_ij = integral of phi_i phi_j              symmetric, positive definite; sums to the area
    S_ij = integral of <grad phi_i, grad phi_j>  symmetric, positive semidefinite; S @ 1 = 0

A signal is an array (size,) or (size, channels): a row for each unknown. Matrices are csr_matrix of scipy.sparse
over the library's own arrays. What is not finite is refused.
"""
from __future__ import annotations

from typing import Any, Optional, Sequence, Union

import numpy as np

from . import _marquetry
from ._arrays import plain_array
from ._errors import InvalidInput, SolverError
from ._meshes import as_mesh
from ._pictures import Picture, as_picture, picture_array
from ._progress import told
from ._types import Array, Progress

__all__ = ["Space", "TexelSpace", "VertexSpace", "ImageSpace", "ScreenedPoisson", "GeodesicDistance", "Solver",
           "smooth", "sharpen"]


def _array(values: Any, name: str) -> Array:
    array = plain_array(values, name)
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{name}: found an array of {array.dtype}, wanted numbers")
    return array


def _number(value: Any, name: str, remedy: str = "") -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: found {value!r}, wanted a number{remedy}") from None


class Space:
    """What every signal space has."""

    _space: _marquetry.Space
    _own: Any

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self._space.size

    def __len__(self) -> int:
        return self.size

    @property
    def area(self) -> float:
        """Of the surface, model units squared."""
        return self._space.area

    @property
    def texel_spacing(self) -> float:
        """Mean distance of neighbouring texels, model units; 0: there are none."""
        return self._space.texel_spacing

    def weight(self, length: Union[str, float]) -> float:
        """The weight of the stiffness for a distance over which values spread, its square: 0.02 in model units,
        "1%" of the square root of the area, "8tx" in texels."""
        return self._space.weight(length if isinstance(length, str) else repr(_number(length, "length")))

    def mass(self) -> Any:
        """M."""
        return self._space.system(1.0, 0.0, None)

    def stiffness(self) -> Any:
        """S."""
        return self._space.system(0.0, 1.0, None)

    def system(self, a: float, b: float, progress: Progress = None) -> Any:
        """a M + b S."""
        return told(progress, self._space.system, _number(a, "a"), _number(b, "b"))

    def regularised_system(self, a: float, b: float, progress: Progress = None) -> Any:
        """What to solve with in place of a M + b S: with a trace of smoothness for unknowns that no point of the
        surface shows, and which the equations would leave arbitrary."""
        return told(progress, self._space.regularised_system, _number(a, "a"), _number(b, "b"))

    def weighted_system(self, a: float, b: float, conductivity: Any, progress: Progress = None) -> Any:
        """a M + b sum_e c_e S_e with a conductivity c_e >= 0 for each element, regularised as for solving."""
        return told(progress, self._space.weighted_system, _number(a, "a"), _number(b, "b"),
                    _array(conductivity, "conductivity"))

    def lumped_mass(self) -> Array:
        """M @ 1, the area around each unknown; sums to the area."""
        return self._space.lumped_mass()  # type: ignore[no-any-return]

    def stiffness_times(self, psi: Any, beta: Any = None) -> Array:
        """S @ psi without a matrix; with a factor on the gradients for each unknown, the integrals of
        beta <grad psi, grad phi_i>."""
        factors = None if beta is None else _array(beta, "beta")
        return self._space.stiffness_times(_array(psi, "psi"), factors)  # type: ignore[no-any-return]

    @property
    def element_count(self) -> int:
        """The elements that the surface is cut into: triangles, or cells between texels and strips at seams."""
        return self._space.element_count

    def gradient_norms(self, psi: Any) -> Array:
        """For each element the root mean square of |grad psi| on it, over all channels."""
        return self._space.gradient_norms(_array(psi, "psi"))  # type: ignore[no-any-return]

    def weighted_stiffness_times(self, psi: Any, conductivity: Any) -> Array:
        """sum_e c_e S_e psi."""
        return self._space.weighted_stiffness_times(  # type: ignore[no-any-return]
            _array(psi, "psi"), _array(conductivity, "conductivity"))

    def positions(self) -> Array:
        """(size, 3): where the unknowns lie, model units."""
        return self._space.positions()  # type: ignore[no-any-return]

    def boundary(self) -> Array:
        """The unknowns whose functions do not vanish on the boundary of the surface, ascending."""
        return self._space.boundary()  # type: ignore[no-any-return]

    def basis_at(self, faces: Any, barycentric: Any) -> Any:
        """A matrix (points, size) of the basis functions at points: B @ psi are the values of a signal there.

        faces (points,) whole numbers; barycentric (points, 3), the weights of the corners, of sum 1."""
        return self._own.basis_at(plain_array(faces, "faces"), _array(barycentric, "barycentric"))

    def gradient(self) -> Any:
        """The gradient as a matrix; divergence() @ gradient() is S."""
        return self._own.gradient()

    def divergence(self) -> Any:
        """The weak divergence, minus div: the integrals of <X, grad phi_i> of fields as gradient() gives them."""
        return self._own.divergence()

    def solver(self, a: float, b: float, solver: str = "automatic", tolerance: float = 1e-6, cycles: int = 0,
               progress: Progress = None) -> "Solver":
        """A prepared solver for a M + b S, regularised."""
        return Solver(self.regularised_system(a, b), self, solver, tolerance, cycles, progress)

    def defects(self) -> list[dict[str, Any]]:
        """What was found wrong with the mesh and its charts: "kind", "severity", "count", "ids", "message".

        Of texels also the largest "places": "texture", "column" and "row" of a texel amid each, its "texels".
        """
        return self._own.defects()  # type: ignore[no-any-return]


class _Texels(Space):
    """A space whose unknowns are texels of pictures."""

    _own: _marquetry.TexelSpace

    @property
    def sizes(self) -> list[tuple[int, int]]:
        """(width, height) of the textures."""
        return self._own.sizes

    def texels(self) -> Array:
        """(size, 3): texture, column and row of the texel of each unknown, row 0 on top."""
        return self._own.texels()  # type: ignore[no-any-return]

    def edges(self) -> Array:
        """(edges, 2): the pairs of unknowns that S couples; rows of gradient()."""
        return self._own.edges()  # type: ignore[no-any-return]

    def gather(self, pictures: Any) -> Array:
        """The values of the unknowns, one row each: one picture, or a list of one for each texture. Integers
        are divided by their largest value."""
        return self._own.gather(_pictures(pictures))  # type: ignore[no-any-return]

    def scatter(self, signal: Any, pictures: Any) -> Any:
        """The pictures with the signal's values at the texels of the unknowns, of the same kind; others stay."""
        made = [as_picture(one) for one in self._own.scatter(_array(signal, "signal"), _pictures(pictures))]
        return made if isinstance(pictures, (list, tuple)) else made[0]


def _pictures(pictures: Any) -> list[Array]:
    given = list(pictures) if isinstance(pictures, (list, tuple)) else [pictures]
    return [picture_array(one, "pictures") for one in given]


def _sizes(sizes: Any) -> list[tuple[int, int]]:
    """One side, (width, height), a picture, or a list of such."""
    given = sizes if isinstance(sizes, list) else [sizes]
    wanted = "wanted a side, (width, height), a picture, or a list of these"
    if not given:
        raise InvalidInput(f"sizes: found an empty list, {wanted}")
    found = []
    for one in given:
        if isinstance(one, (int, np.integer)) and not isinstance(one, bool):
            found.append((int(one), int(one)))
        elif isinstance(one, tuple) and len(one) == 2 and all(isinstance(side, (int, np.integer)) for side in one):
            found.append((int(one[0]), int(one[1])))
        elif isinstance(one, (str, bytes, tuple, float, bool, type(None))):
            raise TypeError(f"sizes: found {one!r}, {wanted}")
        else:
            array = picture_array(one, "sizes")
            if array.ndim not in (2, 3):
                raise InvalidInput(f"sizes: found an array of shape {array.shape}, {wanted}")
            found.append((array.shape[1], array.shape[0]))
    for width, height in found:
        if not (1 <= width <= 32768 and 1 <= height <= 32768):
            raise InvalidInput(f"sizes: found {width} x {height}, wanted 1 to 32768 texels a side")
    return found


class TexelSpace(_Texels):
    """The texels of a mesh's textures: functions bilinear inside charts and continuous across every seam.

    mesh     a Mesh, (vertices, faces, uvs) or an object that has these; with texture coordinates
    sizes    of the textures: a side, (width, height), a picture, or a list of one for each; None: the mesh's own
    weld     which vertices are one point: "exact" at equal positions, "none", or a distance
    flipped  triangles flipped inside their chart: "few" are kept, "refuse" or "keep" all

    gradient() has a row for each edge of `edges()`: the difference along it.
    """

    def __init__(self, mesh: Any, sizes: Any = None, weld: Union[str, float] = "exact", flipped: str = "few",
                 progress: Progress = None) -> None:
        self.mesh = as_mesh(mesh)
        if self.mesh.uvs is None:
            raise InvalidInput("mesh: has no texture coordinates: unwrap it first, or take its VertexSpace")
        if sizes is None and not self.mesh.pictures:
            raise InvalidInput("sizes: the mesh has no pictures, so say how large its textures are")
        wanted = _sizes(list(self.mesh.pictures) if sizes is None else sizes)
        self._own = told(progress, _marquetry.TexelSpace, self.mesh.vertices, self.mesh.faces, self.mesh.uvs,
                         self.mesh.textures, wanted, weld, flipped)
        self._space = self._own.space


class ImageSpace(_Texels):
    """The pixels of an image, row by row: lengths are in pixels.

    ImageSpace(width, height) or ImageSpace(picture).
    """

    def __init__(self, width: Any, height: Optional[int] = None, progress: Progress = None) -> None:
        size = _sizes(width if height is None else (width, height))[0]
        self._own = told(progress, _marquetry.TexelSpace.of_image, size[0], size[1])
        self._space = self._own.space


class VertexSpace(Space):
    """The hat functions of a triangle mesh, linear in each face.

    weld  which vertices are one point: "exact" at equal positions, "none", or a distance. Unknowns are the points.

    gradient() has two rows for each face: the gradient in the face's own frame, whose first axis runs along its
    first edge.
    """

    _own: _marquetry.VertexSpace

    def __init__(self, mesh: Any, weld: Union[str, float] = "exact") -> None:
        self.mesh = as_mesh(mesh)
        self._own = _marquetry.VertexSpace(self.mesh.vertices, self.mesh.faces, weld)
        self._space = self._own.space

    def gather(self, values: Any) -> Array:
        """A signal of values at the mesh's vertices, (V,) or (V, channels)."""
        array = _array(values, "values")
        if array.ndim not in (1, 2) or len(array) != len(self.mesh.vertices) or not array.size:
            raise InvalidInput(f"values: found an array of shape {array.shape}, wanted a row for each of "
                               f"{len(self.mesh.vertices)} vertices")
        if not np.isfinite(array).all():
            raise InvalidInput("values: found some that are not finite, wanted finite numbers")
        return array[self._own.source_from_vertex()]  # type: ignore[no-any-return]

    def scatter(self, signal: Any, values: Any) -> Array:
        """The values at the mesh's vertices with the signal's in their place; vertices of no face keep theirs."""
        made, given = plain_array(values, "values").copy(), _array(signal, "signal")
        point = self._own.vertex_from_source()
        if len(made) != len(point) or given.shape != (self.size, *made.shape[1:]):
            raise InvalidInput(f"signal: found an array of shape {given.shape} for values of shape {made.shape}, wanted "
                               f"({self.size}, ...) for ({len(point)}, ...)")
        made[point >= 0] = given[point[point >= 0]]
        return made


def _space_of(value: Any) -> _marquetry.Space:
    if not isinstance(value, Space):
        raise TypeError(f"space: found {type(value).__name__}, wanted a TexelSpace, a VertexSpace or an ImageSpace")
    return value._space


#: A length is no weight yet.
_FROM_LENGTH = ', such as space.weight("3tx")'


class _Equation:
    report: dict[str, Any]
    """How the last solve went: "method", "cycles", "residuals", "converged", ..."""


class ScreenedPoisson(_Equation):
    """(M + w S) phi = M psi + w S_beta psi: keeps values and multiplies gradients by beta.

    It is solved for what changes, phi = psi + delta, (M + w S) delta = w (S_beta - S) psi, with
    space.regularised_system(1, w) on the left: texels of which hardly anything lies on the surface have nearly no
    part in M and S, and what a direct solve of the line above gives them is noise. With scipy:

        A = space.regularised_system(1, w)
        phi = psi + scipy.sparse.linalg.spsolve(A.tocsc(), w * (beta - 1) * (space.stiffness() @ psi))

    Prepared once for a weight, such as space.weight("3tx"), and solved for many signals. beta 0 smooths, 1 changes
    nothing, more sharpens; a number or one for each unknown. screen: for each unknown how much its value counts,
    0 where it is filled in.
    """

    _own: _marquetry.ScreenedPoisson

    def __init__(self, space: Space, weight: float, screen: Any = None, solver: str = "automatic",
                 tolerance: float = 1e-6, cycles: int = 0, progress: Progress = None) -> None:
        self.space = space
        values = None if screen is None else _array(screen, "screen")
        self._own = told(progress, _marquetry.ScreenedPoisson, _space_of(space),
                         _number(weight, "weight", _FROM_LENGTH), values, solver, tolerance, cycles)
        self.report = {}

    @property
    def weight(self) -> float:
        return self._own.weight

    def set_weight(self, weight: float, progress: Progress = None) -> None:
        """Prepares for another weight."""
        told(progress, self._own.set_weight, _number(weight, "weight", _FROM_LENGTH))

    def solve(self, psi: Any, beta: Any = 0.0, progress: Progress = None) -> Array:
        """phi."""
        factor = beta if isinstance(beta, (int, float)) else _array(beta, "beta")
        if isinstance(factor, np.ndarray) and factor.ndim == 0:
            factor = float(factor)
        signal, self.report = told(progress, self._own.solve, _array(psi, "psi"), factor)
        return signal  # type: ignore[no-any-return]

    def solve_towards(self, psi: Any, moments: Any, progress: Progress = None) -> Array:
        """phi for any gradient X to come near to, given by its moments, the integrals of <X, grad phi_i>."""
        signal, self.report = told(progress, self._own.solve_towards, _array(psi, "psi"), _array(moments, "moments"))
        return signal  # type: ignore[no-any-return]


class GeodesicDistance(_Equation):
    """Distances along the surface by the heat method; prepared once, for many sources.

    time  how long heat spreads, in squared spacings of the unknowns
    """

    def __init__(self, space: Space, time: float = 4.0, solver: str = "automatic", tolerance: float = 1e-6,
                 cycles: int = 0, progress: Progress = None) -> None:
        self.space = space
        self._own = told(progress, _marquetry.GeodesicDistance, _space_of(space), _number(time, "time"), solver,
                         tolerance, cycles)
        self.report = {}

    def from_(self, unknowns: Union[int, Sequence[int], Array], distances: Any = None,
              progress: Progress = None) -> Array:
        """The distance of every unknown from the nearest of these, whose own are 0 or as given; model units,
        infinite where no path leads."""
        sources = np.atleast_1d(plain_array(unknowns, "unknowns"))
        if not sources.size:
            raise InvalidInput("unknowns: found none, wanted one or more to begin at")
        known = None if distances is None else np.atleast_1d(_array(distances, "distances"))
        distance, self.report = told(progress, self._own.from_, sources, known)
        return distance  # type: ignore[no-any-return]


# Of a positive definite matrix what a factorisation misses is rounding.
_MOST_MISSED = 1e-6


class Solver(_Equation):
    """A X = B for a symmetric, positive definite matrix of scipy.sparse, prepared once.

    With the space that it is a matrix of, of the form a M + b S or weighted_system, the library's multigrid solves
    it; without, a factorisation.
    """

    def __init__(self, matrix: Any, space: Optional[Space] = None, solver: str = "automatic", tolerance: float = 1e-6,
                 cycles: int = 0, progress: Progress = None) -> None:
        self.space = space
        self._own = told(progress, _marquetry.Solver, matrix, None if space is None else _space_of(space), solver,
                         tolerance, cycles)
        self.report = {}

    def solve(self, b: Any, guess: Any = None, progress: Progress = None) -> Array:
        """X for right-hand sides B, (size,) or (size, channels)."""
        first = None if guess is None else _array(guess, "guess")
        solution, self.report = told(progress, self._own.solve, _array(b, "b"), first)
        missed = self.report["residuals"][-1] if self.report["residuals"] else 0
        if self.space is None and not missed < _MOST_MISSED:
            raise SolverError(f"matrix: is singular, or nearly: what its factorisation finds misses b by {missed:.2g} "
                              "of it; wanted a positive definite one, such as regularised_system(1, w)")
        return solution  # type: ignore[no-any-return]


def smooth(space: Space, signal: Any, length: Union[str, float], progress: Progress = None) -> Array:
    """The signal without details smaller than about 2 pi times the length."""
    _space_of(space)
    return ScreenedPoisson(space, space.weight(length), progress=progress).solve(signal, 0.0)


def sharpen(space: Space, signal: Any, length: Union[str, float], beta: float,
            progress: Progress = None) -> Array:
    """The signal with details smaller than about 2 pi times the length amplified by up to beta."""
    _space_of(space)
    return ScreenedPoisson(space, space.weight(length), progress=progress).solve(signal, beta)
