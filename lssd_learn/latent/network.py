"""The functional map network: shapes joined by maps between their function spaces."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.cycles import cycle_errors
from lssd_learn.latent.explicit import ExplicitForm
from lssd_learn.latent.factorised import FactorisedForm
from lssd_learn.latent.factors import Factors, compressed_factors, exact_factors
from lssd_learn.latent.graphs import topology
from lssd_learn.latent.refine import refined_maps
from lssd_learn.maps import from_correspondence
from lssd_learn.shapes import Eigenbasis

Maps = Callable[[int, int], np.ndarray | Tensor]

# Up to so many multiplications every map of a correspondence is built exactly, in a fraction of a second; above, the
# factored form costs less.
EXACT_PRODUCTS = 1e10
# Edges are weighed by what their maps do to so many functions: of higher ones truncation spoils all maps alike.
CYCLE_FUNCTIONS = 20
# Up to this many vertices the factored form needs no compression.
EXACT_VERTICES = 400


@dataclass(frozen=True, eq=False)
class MapNetwork:
    """A connected graph on n shapes with functional maps on its edges. Made by its class methods.

    Attributes:
        bases: n eigenbases of k functions.
        edges: (m, 2) pairs i < j, each standing for both directions; None is the clique, which needs no list.
        weights: (m,) one an edge, or, of a clique, (n,) factors u of w_ij = u_i u_j; None is 1; "cycle" weighs every
            edge by how near its cycles come to the identity, see `cycle_weights`.
        maps: (i, j) → C_ij, carrying functions on i to functions on j; None is vertex identity, which needs shapes of
            one connectivity.
        evals: Λ, the eigenvalues (n, k) of all shapes.

    Examples:
        >>> import lssd_learn as lssd
        >>> spheres = lssd.collections.Bumps(subdivisions=2)
        >>> bases = [lssd.eigenbasis(sphere, k=10) for sphere in spheres]
        >>> clique = lssd.MapNetwork.clique(bases)  # vertex i of one is vertex i of all
        >>> len(lssd.MapNetwork.chain(bases).edges)
        3
    """

    bases: Sequence[Eigenbasis]
    edges: Int[np.ndarray, "m 2"] | None = None
    weights: np.ndarray | str | None = None
    maps: Maps | None = None
    evals: Float[np.ndarray, "n k"] = field(init=False)

    def __post_init__(self):
        n = len(self.bases)
        if n < 2:
            raise InputError(f"a network needs at least 2 shapes, got {n}")
        evals, connectivities = zip(*((b.evals, b.connectivity) for b in self.bases), strict=True)  # each opened once
        functions = [len(e) for e in evals]
        if len(set(functions)) > 1:
            raise InputError(f"bases: expected as many functions on each, got {min(functions)} to {max(functions)}")
        object.__setattr__(self, "evals", np.stack([np.asarray(e, dtype=float) for e in evals]))
        if self.maps is None:
            first, *others = connectivities
            odd = [i for i, c in enumerate(others, start=1) if c != first]
            if first is None or odd:
                which = f"shape {odd[0]} differs from shape 0" if odd else "the shapes are point clouds"
                raise InputError(
                    f"maps: vertex identity needs shapes of one connectivity, but {which}; choose other maps"
                )
        expected = n if self.edges is None else len(self.edges)
        if isinstance(self.weights, str):
            if self.weights != "cycle":
                raise InputError(f"weights={self.weights}: expected cycle, numbers or null")
        elif self.weights is not None:
            _positive(self.weights, expected)

    @classmethod
    def clique(cls, bases: Sequence[Eigenbasis], maps: Maps | None = None, weights=None) -> "MapNetwork":
        """Every pair; weights u (n,) make w_ij = u_i u_j."""
        return cls(bases, None, weights, maps)

    @classmethod
    def nearest(
        cls, bases, neighbours: int, maps: Maps | None = None, unit_area: bool = False, weights: str | None = None
    ) -> "MapNetwork":
        """Every shape with its nearest by Shape-DNA distance, symmetrised by union; joined up if it falls apart."""
        return cls(bases, topology.nearest(_points(bases, unit_area), neighbours), weights, maps)

    @classmethod
    def spanning_tree(
        cls, bases, maps: Maps | None = None, unit_area: bool = False, weights: str | None = None
    ) -> "MapNetwork":
        """The minimum spanning tree of the Shape-DNA distances."""
        return cls(bases, topology.spanning_tree(_points(bases, unit_area)), weights, maps)

    @classmethod
    def chain(cls, bases, maps: Maps | None = None) -> "MapNetwork":
        """Each shape with the next."""
        return cls(bases, topology.chain(len(bases)), None, maps)

    chain.__func__.in_order = True  # the shapes are a sequence: pictures join them by a line

    @classmethod
    def star(cls, bases, centre: int = 0, maps: Maps | None = None) -> "MapNetwork":
        """Each shape with one centre."""
        return cls(bases, topology.star(len(bases), centre), None, maps)

    @classmethod
    def hubs(
        cls, bases, hubs: int, maps: Maps | None = None, unit_area: bool = False, weights: str | None = None
    ) -> "MapNetwork":
        """Every shape with the same few, which lie in the midst of the others: as cheap as a few neighbours, and no
        two shapes are far apart, so that maps with errors of their own do not add up."""
        return cls(bases, topology.hubs(_points(bases, unit_area), hubs), weights, maps)

    @classmethod
    def clusters(
        cls,
        bases,
        labels: Iterable,
        maps: Maps | None = None,
        unit_area: bool = False,
        weights: str | None = None,
    ) -> "MapNetwork":
        """A spanning tree in each cluster, and each shape with its nearest in the other clusters."""
        return cls(bases, topology.clusters(_points(bases, unit_area), labels), weights, maps)

    @classmethod
    def from_edges(cls, bases, edges, maps: Maps | None = None, weights=None) -> "MapNetwork":
        """Edges of one's own: (m, 2) pairs of shape numbers, both directions meant; weights one an edge.

        Raises:
            InputError: a pair outside the collection, a pair twice, or a graph that is not connected.
        """
        edges = _pairs(edges)
        n = len(bases)
        if len(edges) and (edges.min() < 0 or edges.max() >= n):
            raise InputError(f"edges: expected shape numbers 0 to {n - 1}, got {edges.min()} to {edges.max()}")
        if np.any(edges[:, 0] == edges[:, 1]) or len(topology.tidy(edges)) != len(edges):
            raise InputError("edges: expected each pair of two shapes once, got a loop or a repeated pair")
        pieces = topology.components(n, edges)
        if len(pieces) > 1:
            told = "; ".join("{" + ", ".join(map(str, p[:5])) + (", …}" if len(p) > 5 else "}") for p in pieces[:4])
            raise InputError(f"edges: expected a connected network, got {len(pieces)} components: {told}")
        given = weights if weights is None or isinstance(weights, str) else _positive(weights, len(edges))
        return cls(bases, edges, given, maps)

    def __repr__(self) -> str:
        edges = "clique" if self.edges is None else f"{len(self.edges):,} edges"
        maps = "vertex identity" if self.maps is None else type(self.maps).__name__
        return f"MapNetwork({self.n:,} shapes of {self.k} functions, {edges}, maps: {maps})"

    @property
    def n(self) -> int:
        """Number of shapes."""
        return len(self.bases)

    @property
    def k(self) -> int:
        """Number of eigenfunctions a shape."""
        return self.evals.shape[1]

    @property
    def _directed_edges(self) -> int:
        return self.n * (self.n - 1) if self.edges is None else 2 * len(self.edges)

    def pairs(self) -> Int[np.ndarray, "m 2"]:
        """(m, 2) the pairs i < j that are mapped, those of a clique too."""
        return topology.clique(self.n) if self.edges is None else self.edges

    def map(self, i: int, j: int) -> Float[np.ndarray, "k k"] | Float[Tensor, "k k"]:
        """C_ij (k, k), which carries functions on shape i to functions on shape j."""
        return from_correspondence(self.bases[i], self.bases[j]) if self.maps is None else self.maps(i, j)

    def truncated(self, k: int) -> "MapNetwork":
        """The same network of the first k functions of each shape."""
        maps = self.maps
        cut = None if maps is None else lambda i, j: maps(i, j)[:k, :k]
        return replace(self, bases=[basis.truncate(k) for basis in self.bases], maps=cut)

    def with_maps(self, maps: Maps) -> "MapNetwork":
        """The same shapes and edges with other maps."""
        return replace(self, maps=maps)

    def only(self, kept: Bool[np.ndarray, " m"]) -> "MapNetwork":
        """The network with some of its edges, a mask in the order of `pairs`; they have to connect the shapes."""
        weights = self.weights
        if weights is not None and not isinstance(weights, str):
            weights = np.asarray(weights)
            weights = weights[self.pairs()].prod(axis=1)[kept] if self.edges is None else weights[kept]
        return replace(self, edges=self.pairs()[kept], weights=weights)

    def refine(self, first: int = 20, last: int = 50, step: int = 5) -> "MapNetwork":
        """The network after Consistent ZoomOut from `first` to `last` functions, see `refine.refined_maps`."""
        return self.with_maps(refined_maps(self, first, last, step))

    def cycle_weights(self) -> Float[np.ndarray, " m"]:
        """(m,) weights of the edges, 1 / (1 + (e / median e)²), e how far the cycles of an edge are from the identity.

        See `cycle_errors`.
        """
        errors = cycle_errors(self.pairs(), self.map, min(self.k, CYCLE_FUNCTIONS))
        return 1 / (1 + (errors / max(np.median(errors), np.finfo(float).tiny)) ** 2)

    def form(self, method: str = "auto", rank: int | None = None, device: torch.device | str = "cpu"):
        """The energy of the network as a quadratic form.

        Args:
            method: "explicit" builds each map exactly; "factorised" takes C_ij = B_jᵀA_i from a common basis of `rank`
                functions (vertex identity only); "auto" is explicit for small or computed networks.
            rank: functions of the common basis; None is enough for the operators' eigenvalues to agree to about 1e-4.
            device: of the tensors.
        """
        if method not in ("auto", "explicit", "factorised"):
            raise InputError(f"method={method!r}: expected auto, explicit or factorised")
        small = self._directed_edges * len(self.bases[0].mass) * self.k**2 <= EXACT_PRODUCTS
        if method == "factorised" and self.maps is not None:
            raise InputError(
                "method='factorised': only for shapes in vertex correspondence; these have maps of their own"
            )
        small = small or isinstance(self.weights, str)
        if method == "explicit" or self.maps is not None or (method == "auto" and small):
            return self._explicit(
                lambda i, targets: torch.stack([torch.as_tensor(self.map(i, j)) for j in targets]).to(
                    device, torch.float64
                )
            )
        factors = self.factors(rank, device)
        if self.edges is None:
            return FactorisedForm(factors, None if self.weights is None else torch.as_tensor(self.weights))
        return self._explicit(factors.maps)

    def factors(self, rank: int | None = None, device: torch.device | str = "cpu") -> Factors:
        """The maps of a vertex correspondence in factored form, exact for small meshes."""
        if rank is None and len(self.bases[0].mass) <= EXACT_VERTICES:
            return exact_factors(self.bases, device)
        return compressed_factors(self.bases, rank, device=device)

    def _explicit(self, maps: Callable[[int, Sequence[int]], Tensor]) -> ExplicitForm:
        edges = self.pairs()
        if self.weights is None:
            weights = np.ones(len(edges))
        elif isinstance(self.weights, str):
            weights = self.cycle_weights()
        elif self.edges is None:
            weights = np.asarray(self.weights)[edges].prod(axis=1)
        else:
            weights = np.asarray(self.weights)
        both_ways = np.concatenate([edges, edges[:, ::-1]])
        return ExplicitForm(self.n, both_ways, np.concatenate([weights, weights]), maps)


def _pairs(edges) -> np.ndarray:
    """(m, 2) int64."""
    try:
        array = np.asarray(edges)
    except ValueError:  # rows of different lengths
        array = None
    if array is not None and array.shape[:1] == (0,):
        return np.empty((0, 2), dtype=np.int64)
    if array is None or array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise InputError(f"edges: expected pairs of shape numbers, as in [[0, 1], [1, 2]], got {_short(edges)}")
    return array.astype(np.int64)


def _positive(weights, count: int) -> np.ndarray:
    """(count,) float64."""
    try:
        array = np.asarray(weights, dtype=float)
    except (TypeError, ValueError):
        array = None
    if array is None or array.shape != (count,) or not (array > 0).all():
        raise InputError(f"weights: expected {count} positive numbers, got {_short(weights)}")
    return array


def _short(values) -> str:
    text = " ".join(str(values).split())
    return text if len(text) <= 60 else f"{text[:60]}…"


def _points(bases: Sequence[Eigenbasis], unit_area: bool) -> np.ndarray:
    evals = np.stack([b.evals for b in bases])
    return topology.shape_dna(evals, np.array([b.mass.sum() for b in bases]) if unit_area else None)
