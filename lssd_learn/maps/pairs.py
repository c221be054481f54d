"""The maps of a collection: which of its pairs are mapped, and how. What the config group `maps` chooses from.

Each is made from the eigenbases and the collection they belong to, and is then a function (i, j) → C_ij. The computed
ones are in `computed.py`.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from itertools import combinations

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.shapes import Eigenbasis


class PairMaps:
    """(i, j) → C_ij, carrying functions on shape i to functions on shape j. Subclasses give `__call__`.

    Args:
        bases: n eigenbases.
        collection: the n shapes, and what is known about them.
    """

    version: int | None = None  # of the algorithm, where there is one
    computed = False  # whether it computes maps of shapes that do not correspond
    known = 0  # so many shapes at the front of the collection are old ones, to which new ones are mapped
    level = 0.0  # quality, 0 to 1, that a map has to reach to be trusted, where it is known

    def __init__(self, bases: Sequence[Eigenbasis], collection: Collection):
        self._bases, self._collection = bases, collection

    @property
    def shapes(self) -> Collection:
        """The collection."""
        return self._collection

    @property
    def turned(self) -> bool:
        """Whether shapes may be turned against one another."""
        return False

    @property
    def is_identity(self) -> bool:
        """Whether all shapes have one connectivity, so that no map is needed at all."""
        return len(set(self._connectivity)) == 1 and self._connectivity[0] is not None

    @cached_property
    def _connectivity(self) -> list[str | None]:
        return [basis.connectivity for basis in self._bases]

    def _correspond(self, i: int, j: int) -> bool:
        """Whether vertex v of shape i is vertex v of shape j."""
        return self._connectivity[i] is not None and self._connectivity[i] == self._connectivity[j]

    def __call__(self, i: int, j: int) -> Float[np.ndarray, "k_j k_i"]:
        raise NotImplementedError

    def points(self, i: int, j: int) -> tuple[Int[np.ndarray, "V_j 3"], Float[np.ndarray, "V_j 3"]]:
        """For each vertex of shape j three vertices of shape i, and its place among them: weights of sum 1."""
        same = self._correspond(i, j)
        vertices = np.arange(len(self._bases[j].mass)) if same else self.vertices(i, j)
        return np.repeat(vertices[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (len(vertices), 1))

    def vertices(self, i: int, j: int) -> Int[np.ndarray, " V_j"]:
        """(V_j,) for each vertex of shape j one of shape i, of shapes that do not correspond."""
        raise NotImplementedError

    def quality(self, i: int, j: int) -> float | None:
        """How likely the map is right, in [0, 1]; None where nothing is known of it."""
        return None

    def unreached(self, i: int, j: int) -> tuple[float, float] | None:
        """The shares of the area of shape i that no point of j is mapped near to, and of j that none of i is.

        What a shape lacks is not reached on the other. None where nothing is known of it.
        """
        return None

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, **arguments) -> None:
        """Look for what the maps of a collection need, before its eigenbases are computed.

        Args:
            collection: n shapes; where nothing is known of their faces, nothing is looked for.
            every_pair: whether all pairs will be mapped, or only as many as connect the shapes.
            arguments: of the constructor.

        Raises:
            InputError: something is missing; names what else would do.
        """

    def prepare(self, pairs: Iterable[tuple[int, int]], workers: int | None = None) -> None:
        """Compute, or read, the maps of all these pairs, both directions, before they are asked for one by one.

        Args:
            pairs: of shapes, in any order.
            workers: processes; see `in_parallel`.
        """

    def keep_in(self, cache: Cache, key: Callable[[int, int, list], str]) -> None:
        """Keep what is computed of a pair in `cache`, from now on.

        Args:
            cache: the store.
            key: two shapes and what else their maps depend on → the name of the entry.
        """


class VertexMaps(PairMaps):
    """Maps from vertex correspondences: identity between shapes of one connectivity, given maps elsewhere.

    A map given for one pair serves every pair of the same two connectivities. The collection's `vertex_maps` are given,
    its `names` are for messages.
    """

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, **arguments) -> None:
        kinds = collection.connectivities
        if kinds is None or (len(set(kinds)) == 1 and kinds[0] is not None):
            return
        given = collection.vertex_maps
        # A shape without faces is a kind of its own.
        kinds = [f"shape {i}" if kind is None else kind for i, kind in enumerate(kinds)]
        first = {kind: i for i, kind in reversed(list(enumerate(kinds)))}
        mapped = {(kinds[a], kinds[b]) for a, b in given}
        if every_pair:
            pairs = combinations(sorted(first.values()), 2)
            lacking = next(((a, b) for a, b in pairs if (kinds[a], kinds[b]) not in mapped), None)
            if lacking is not None and lacking not in given:
                raise InputError(_lacking(collection, *lacking))
            return
        number = {kind: k for k, kind in enumerate(first)}
        links = np.array([(number[a], number[b]) for a, b in mapped], dtype=int).reshape(-1, 2)
        graph = coo_array((np.ones(len(links)), tuple(links.T)), shape=(len(number), len(number)))
        count, part = connected_components(graph.tocsr(), directed=False)
        if count > 1:
            other = int(np.argmax(part != part[0]))
            raise InputError(_lacking(collection, *sorted(list(first.values())[k] for k in (0, other))))

    @cached_property
    def _by_connectivity(self) -> dict[tuple[str | None, str | None], tuple[int, int]]:
        kinds = self._connectivity
        given = self._collection.vertex_maps
        return {(kinds[a], kinds[b]): (a, b) for a, b in given if kinds[a] is not None and kinds[b] is not None}

    def given(self, i: int, j: int) -> Int[np.ndarray, " V_j"] | None:
        """For each vertex of shape j the vertex of shape i, where that is given; None where nobody said."""
        given, kinds = self._collection.vertex_maps, (self._connectivity[i], self._connectivity[j])
        if (i, j) in given:
            return given[i, j]
        return given[self._by_connectivity[kinds]] if kinds in self._by_connectivity else None

    def vertices(self, i: int, j: int) -> Int[np.ndarray, " V_j"]:
        given = self.given(i, j)
        if given is None:
            raise InputError(_lacking(self._collection, i, j))
        return given

    def __call__(self, i: int, j: int) -> Float[np.ndarray, "k_j k_i"]:
        vertices = self.given(i, j) if (i, j) in self._collection.vertex_maps or not self._correspond(i, j) else None
        if vertices is None and not self._correspond(i, j):
            raise InputError(_lacking(self._collection, i, j))
        return from_correspondence(self._bases[i], self._bases[j], vertices)


def _lacking(collection: Collection, i: int, j: int) -> str:
    """What is missing between two shapes, and what would do."""
    a, b = collection.names[i], collection.names[j]
    marked = "maps=landmarks or spline (landmarks.csv is there), " * bool(len(collection.landmarks))
    return (
        f"maps: {a} and {b} are not in vertex correspondence; expected maps/{a}__{b}.txt, or a map between two shapes "
        f"with their faces, or {marked}maps=kernel_matching or registration (shapes that stand upright, facing one way)"
    )
