"""The maps of a collection: which of its pairs are mapped, and how."""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.errors import InputError
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.shapes import Eigenbasis


class VertexMaps:
    """(i, j) → C_ij from vertex correspondences: identity between shapes of one connectivity, given maps elsewhere.

    A map given for one pair serves every pair of the same two connectivities.

    Args:
        bases: n eigenbases.
        given: (a, b) → for each vertex of b the vertex of a.
        names: n, for messages.
    """

    def __init__(self, bases: Sequence[Eigenbasis], given: Mapping[tuple[int, int], np.ndarray], names: Sequence[str]):
        self._bases, self._given, self._names = bases, given, names

    @property
    def is_identity(self) -> bool:
        """Whether all shapes have one connectivity, so that no map is needed at all."""
        return len(set(self._connectivity)) == 1 and self._connectivity[0] is not None

    @cached_property
    def _connectivity(self) -> list[str | None]:
        return [basis.connectivity for basis in self._bases]

    @cached_property
    def _by_connectivity(self) -> dict[tuple[str, str], tuple[int, int]]:
        kinds = self._connectivity
        return {(kinds[a], kinds[b]): (a, b) for a, b in self._given if kinds[a] is not None and kinds[b] is not None}

    def __call__(self, i: int, j: int) -> np.ndarray:
        source, target = self._connectivity[i], self._connectivity[j]
        if (i, j) in self._given:
            vertices = self._given[i, j]
        elif source is not None and source == target:
            vertices = None
        elif (source, target) in self._by_connectivity:
            vertices = self._given[self._by_connectivity[source, target]]
        else:
            a, b = self._names[i], self._names[j]
            raise InputError(
                f"maps: {a} and {b} are not in vertex correspondence; expected maps/{a}__{b}.txt, or a map between two "
                "shapes with their faces"
            )
        return from_correspondence(self._bases[i], self._bases[j], vertices)
