"""The eigenbasis of a shape: what all later stages know of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.sparse import csc_array, csr_array, dia_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, spilu, splu

from lssd_learn.eigensolver import smallest_eigenpairs
from lssd_learn.errors import InputError
from lssd_learn.shapes.given import Given, as_shape, warn_of_unmended
from lssd_learn.shapes.laplacian import laplacian as laplacian_of
from lssd_learn.shapes.mesh import Mesh, Shape
from lssd_learn.shapes.moments import Moments, moments

# For SuperLU: symmetric matrices, and columns one by one, which suits small supernodes.
SYMMETRIC = {"panel_size": 1, "options": {"SymmetricMode": True}}


@dataclass(frozen=True, eq=False)
class Eigenbasis:
    """The first k eigenfunctions of the Laplace–Beltrami operator of a shape with V vertices, Λ, Φ and M.

    Attributes:
        evals: (k,) ascending, in 1 / (unit of length)²; zero for each connected piece, of which there is mostly one.
        evecs: (V, k), a function a column, Φᵀ M Φ = I.
        mass: (V,) the area of each vertex.
        connectivity: a hash of the faces, None for a cloud.
        measure: computes `moments`, or finds them; None where nobody knows the coordinates.

    Examples:
        >>> import lssd_learn as lssd
        >>> basis = lssd.eigenbasis(lssd.collections.Bumps(subdivisions=2)[3], k=10)
        >>> basis.evecs.shape, basis.truncate(4).k
        ((162, 10), 4)
    """

    evals: Float[np.ndarray, " k"]
    evecs: Float[np.ndarray, "V k"]
    mass: Float[np.ndarray, " V"]
    connectivity: str | None = None
    measure: Callable[[], Moments | None] | None = None

    def __repr__(self) -> str:
        return f"Eigenbasis({self.k} functions on {len(self.mass):,} vertices)"

    @property
    def k(self) -> int:
        """The number of eigenfunctions."""
        return len(self.evals)

    @property
    def area(self) -> float:
        """The area of the shape."""
        return float(self.mass.sum())

    @cached_property
    def moments(self) -> Moments | None:
        """Those of the coordinates in these functions, computed when first asked for; None where nobody knows them."""
        return None if self.measure is None else self.measure()

    def truncate(self, k: int) -> "Eigenbasis":
        """The first k of the eigenfunctions.

        Raises:
            InputError: more than there are, or none.
        """
        if not 1 <= k <= self.k:
            raise InputError(f"k: expected 1 to {self.k}, the eigenfunctions there are, got {k}")
        measure = None if self.measure is None else partial(_truncated, self, k)
        return replace(self, evals=self.evals[:k], evecs=self.evecs[:, :k], measure=measure)


def _truncated(basis: Eigenbasis, k: int) -> Moments | None:
    return None if basis.moments is None else basis.moments.truncate(k)


def eigenbasis(shape: Given, k: int, laplacian: str = "auto") -> Eigenbasis:
    """The k eigenfunctions of lowest frequency of `shape`, in float64, LΦ = MΦΛ.

    Signs: the constant is positive, and so is ∫φ³ of every other function. Where that is zero by a symmetry (below a
    hundredth of ∫|φ|³), Σ_v M_v cos(v) φ_v is positive, v the number of the vertex: an arbitrary choice, but the same
    for shapes in correspondence. Functions of a multiple eigenvalue are one of many possible choices. The same input
    gives the same bits at the same thread count.

    Args:
        shape: a mesh without unused vertices (see `clean`), of as many connected pieces as it says, or a cloud; in any
            form `as_shape` takes. A file is mended; of a mesh that would need it, a warning says so.
        k: number of eigenfunctions, 1 ≤ k < V.
        laplacian: `auto`, `cotangent` or `robust`, see `laplacian.laplacian`.

    Raises:
        InputError: k out of range, a shape of several components that says nothing of them, a vertex without area.

    Examples:
        >>> import lssd_learn as lssd
        >>> sphere = lssd.collections.Bumps(subdivisions=4)[0]  # of radius 1: l(l + 1), each 2l + 1 times
        >>> lssd.eigenbasis(sphere, k=4).evals.round(2).tolist()
        [0.0, 2.0, 2.0, 2.0]
    """
    shape = as_shape(shape)
    warn_of_unmended({"shape": shape})
    return eigenbasis_as_is(shape, k, laplacian)


def eigenbasis_as_is(shape: Shape, k: int, laplacian: str = "auto") -> Eigenbasis:
    """The same of a shape that was looked at before, as those of a collection were."""
    n = len(shape.vertices)
    if not 1 <= k < n:
        raise InputError(f"k: expected 1 to {n - 1}, fewer than the shape's {n} vertices, got {k}")
    L, M = laplacian_of(shape, laplacian)
    basis = eigenbasis_of(L, M, k, shape.connectivity, shape.pieces if isinstance(shape, Mesh) else 1)
    return replace(basis, measure=partial(moments, shape.vertices, basis.mass, basis.evecs))


def eigenbasis_of(
    L: csr_array, M: Float[np.ndarray, " V"], k: int, connectivity: str | None = None, pieces: int = 1
) -> Eigenbasis:
    """The same of a stiffness L (V, V) and masses M (V,) of one's own, as of an average shape: see `average.py`.

    Of several pieces, the functions of frequency zero are the constant, and those that are constant on each piece.

    Raises:
        InputError: another number of components than `pieces`, more than functions, a vertex without area.
    """
    n = len(M)
    if not (M > 0).all():
        raise InputError(
            f"shape: {(M <= 0).sum():,} of {n:,} vertices have no area, clean the mesh or use the robust Laplacian"
        )
    count, piece = connected_components(L, directed=False)
    if count > 1 and pieces == 1:
        raise InputError(f"shape: expected one connected piece, got {count:,}; clean() keeps the largest")
    if count > k:
        raise InputError(f"k: expected {count:,} or more, one for each connected piece, got {k}")
    evals, evecs = _solve(L, M, k)
    # The null functions are known exactly; what was found, and the others' share of them, is rounding (much on bad
    # triangles).
    if count == 1:
        evals[0], evecs[:, 0] = 0.0, M.sum() ** -0.5
        evecs[:, 1:] -= M @ evecs[:, 1:] / M.sum()
    else:
        null = _null_functions(piece, M)
        evals[:count], evecs[:, :count] = 0.0, null
        evecs[:, count:] -= null @ (null.T @ (M[:, None] * evecs[:, count:]))
    return Eigenbasis(evals, evecs * _signs(evecs, M), M, connectivity)


def _null_functions(piece: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(V, c) the constant, then for each piece but the last, in the order of their vertices, against the later ones."""
    areas = np.bincount(piece, M)
    functions = np.full((len(M), len(areas)), M.sum() ** -0.5)
    for j in range(len(areas) - 1):
        own, rest = areas[j], areas[j + 1 :].sum()
        values = np.select([piece == j, piece > j], [1 / own, -1 / rest], 0.0)
        functions[:, j + 1] = values / np.sqrt(1 / own + 1 / rest)
    return functions


def _solve(L: csr_array, M: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Λ and Φ by shift and invert, with a shift that suits any unit of length."""
    # Weyl's law: λ_k ≈ 4πk / area. Half way up the wanted eigenvalues the iteration needs a quarter fewer vectors than
    # at zero. The factors of that indefinite matrix are good unless the shift happens to hit an eigenvalue (of the
    # shape or of a part that is eliminated first); then a shift below zero is safe.
    weyl = 4 * np.pi / M.sum()
    root = np.sqrt(M)
    order, symmetric = _ordered(_scaled(L, 1 / root))  # all is done in that order
    for shift in (0.5 * weyl * k, -0.01 * weyl):
        shifted = symmetric - dia_array((np.full((1, len(M)), shift), 0), shape=L.shape)
        factors = _factors(shifted.tocsc(), definite=shift < 0)
        if factors is None:
            continue
        try:
            evals, X = smallest_eigenpairs(factors.solve, len(M), k, shift)
        except ArithmeticError:
            if shift < 0:
                raise
            continue
        return evals, X[order.back] / root[:, None]
    raise ArithmeticError("the Laplacian cannot be factorised")


def _scaled(L: csr_array, factors: np.ndarray) -> csc_array:
    """The symmetric matrix of L_ij f_i f_j."""
    data = L.data * factors[L.indices] * np.repeat(factors, np.diff(L.indptr))
    return csc_array((data, L.indices, L.indptr), shape=L.shape)


def factorised(A: csc_array, definite: bool) -> Callable[[np.ndarray], np.ndarray] | None:
    """X → A⁻¹X of a symmetric A, or None if the factors are not to be trusted."""
    order, ordered = _ordered(A)
    factors = _factors(ordered, definite)
    return None if factors is None else lambda X: factors.solve(X[order.forth])[order.back]


def _factors(A: csc_array, definite: bool) -> SuperLU | None:
    """The factors of a symmetric A whose order is a good one, or None if they are not to be trusted."""
    try:
        # The diagonal as pivots: less fill, and faster by half.
        factors = splu(A, permc_spec="NATURAL", diag_pivot_thresh=0.0 if definite else 0.01, **SYMMETRIC)
    except RuntimeError:  # exactly singular
        return None
    b = np.cos(np.arange(len(A.indptr) - 1))  # any vector that is not smooth
    x = factors.solve(b)
    error = np.abs(A @ x - b).max()
    return factors if error <= 1e-10 * (np.abs(A.data).max() * np.abs(x).max() + 1) else None


class _Pattern:
    """Where a sparse matrix with sorted indices is not zero: shapes of the same faces are alike in it."""

    def __init__(self, A: csc_array) -> None:
        self.indices, self.indptr = A.indices, A.indptr

    def __hash__(self) -> int:
        return hash((len(self.indptr), self.indices[:: len(self.indices) // 64 + 1].tobytes()))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Pattern)
            and np.array_equal(self.indptr, other.indptr)
            and np.array_equal(self.indices, other.indices)
        )


class _Order(NamedTuple):
    """An order of little fill: x[forth] is in it, back undoes that, data[places] is the ordered matrix's."""

    forth: np.ndarray
    back: np.ndarray
    places: np.ndarray
    indices: np.ndarray
    indptr: np.ndarray


def _ordered(A: csc_array) -> tuple[_Order, csc_array]:
    """A symmetric matrix with its rows and columns in an order of little fill, which it has in common with its like."""
    A.sort_indices()
    order = _order(_Pattern(A))
    return order, csc_array((A.data[order.places], order.indices, order.indptr), shape=A.shape)


@lru_cache(maxsize=2)
def _order(pattern: _Pattern) -> _Order:
    """The order of minimum degree. It depends on nothing but the pattern, so that what is known from another shape is
    the same to the last bit."""
    n, nonzeros = len(pattern.indptr) - 1, len(pattern.indices)
    diagonal = np.repeat(np.arange(n), np.diff(pattern.indptr)) == pattern.indices
    # An incomplete factorisation that drops all it may: nothing is wanted of it but its order.
    some = csc_array((np.where(diagonal, 1.0, 1e-9), pattern.indices, pattern.indptr), shape=(n, n))
    back = spilu(some, drop_tol=1.0, fill_factor=1.0, permc_spec="MMD_AT_PLUS_A", **SYMMETRIC).perm_c
    forth = np.argsort(back)
    numbers = csc_array((np.arange(1.0, nonzeros + 1), pattern.indices, pattern.indptr), shape=(n, n))
    ordered = csc_array(numbers[forth][:, forth])
    ordered.sort_indices()
    return _Order(forth, back, ordered.data.astype(np.int64) - 1, ordered.indices, ordered.indptr)


def _signs(evecs: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(k,) ±1 by the rule of `eigenbasis`."""
    cubes = evecs * evecs * evecs
    skew, size = M @ cubes, M @ np.abs(cubes, out=cubes)
    mixed = (M * np.cos(np.arange(len(M)))) @ evecs
    return np.where(np.where(np.abs(skew) > 1e-2 * size, skew, mixed) < 0, -1.0, 1.0)
