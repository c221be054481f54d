"""The maps of a collection whose shapes are not in correspondence, computed pair by pair when they are asked for.

Where a correspondence is known, `correspondence="none"` computes them all the same: to see what they are worth.
"""

import logging
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.maps.adjoint import adjoint
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.kernel_matching import densified, match
from lssd_learn.maps.landmarks import landmark_vertices
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)


class ComputedMaps(PairMaps):
    """Vertex identity between shapes of one connectivity, computed maps elsewhere: both directions of a pair at once.

    The vertex maps of the collection are not used. Subclasses give `vertex_maps`; whoever keeps maps on disk, or weighs
    edges by their quality, does so around that one function.

    Args:
        bases, collection: see `PairMaps`.
        correspondence: "auto", or "none": shapes of one connectivity are no exception.

    Raises:
        InputError: another correspondence.
    """

    def __init__(self, bases: Sequence[Eigenbasis], collection: Collection, correspondence: str = "auto"):
        super().__init__(bases, collection)
        if correspondence not in ("auto", "none"):
            raise InputError(f"maps.correspondence={correspondence}: expected auto or none")
        self._ignored = correspondence == "none"
        self._computed: dict[tuple[int, int], np.ndarray] = {}

    @property
    def is_identity(self) -> bool:
        return not self._ignored and super().is_identity

    def _correspond(self, i: int, j: int) -> bool:
        return not self._ignored and super()._correspond(i, j)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        """(V_j,) for each vertex of shape j one of shape i, and (V_i,) the other way; i < j."""
        raise NotImplementedError

    def __call__(self, i: int, j: int) -> np.ndarray:
        if self._correspond(i, j):
            return from_correspondence(self._bases[i], self._bases[j])
        if (i, j) not in self._computed:
            a, b = min(i, j), max(i, j)  # the result does not depend on which direction is asked for first
            on_b, on_a = self.vertex_maps(a, b)
            self._computed[a, b] = from_correspondence(self._bases[a], self._bases[b], on_b)
            self._computed[b, a] = from_correspondence(self._bases[b], self._bases[a], on_a)
        return self._computed[i, j]


class LandmarkMaps(ComputedMaps):
    """`maps=landmarks`: from the landmarks that all shapes of the collection have.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: how many of them to use, the farthest from one another on the first shape; None is all.
        functions, refined, commutativity: see `landmarks.landmarks`.

    Raises:
        InputError: on the first pair, fewer than three landmarks that all shapes have, or all of a shape on a line.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        landmarks: int | None = None,
        functions: int = 30,
        refined: int | None = 40,
        commutativity: float = 1.0,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        self._landmarks, self._how = landmarks, (functions, refined, commutativity)

    @cached_property
    def _vertices(self) -> np.ndarray:
        return common_landmarks(self._collection, self._landmarks)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        return self._one_way(i, j), self._one_way(j, i)

    def _one_way(self, i: int, j: int) -> np.ndarray:
        return landmark_vertices(self._bases[i], self._bases[j], self._vertices[i], self._vertices[j], *self._how)


class AdjointMaps(ComputedMaps):
    """`maps=adjoint`: both directions in one, regularised by each other; with landmarks where the collection has any.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`; 0 uses none.
        functions: that the pair of maps is computed for.
        trusted: of these, the ones that ZoomOut starts from.
        refined: functions at the end of ZoomOut; None leaves it out.

    Raises:
        InputError: on the first pair, landmarks that do not do.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        landmarks: int | None = None,
        functions: int = 60,
        trusted: int = 30,
        refined: int | None = 40,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        check_whole("maps.functions", functions, 1)
        check_whole("maps.trusted", trusted, 1, functions)
        self._landmarks, self._functions, self._trusted, self._refined = landmarks, functions, trusted, refined

    @cached_property
    def _vertices(self) -> np.ndarray:
        if self._landmarks == 0 or not any(self._collection.landmarks):
            log.warning("maps=adjoint: without landmarks; symmetric shapes may be mapped mirrored")
            return np.empty((len(self._collection), 0), dtype=int)
        return common_landmarks(self._collection, self._landmarks)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        a, b = (basis.truncate(min(self._functions, basis.k)) for basis in (self._bases[i], self._bases[j]))
        there, back = (C[: self._trusted, : self._trusted] for C in adjoint(a, b, self._vertices[i], self._vertices[j]))
        return zoomed_vertices(a, b, there, self._refined), zoomed_vertices(b, a, back, self._refined)


class KernelMatchingMaps(ComputedMaps):
    """`maps=kernel_matching`: nothing but the shapes is needed, standing upright and facing one way.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        samples, steps, extrinsic, smoothness, functions, refined, seed: see `kernel_matching.kernel_matching`.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        samples: int = 1000,
        steps: int = 8,
        extrinsic: float = 1.0,
        smoothness: float = 1.0,
        functions: int = 80,
        refined: int | None = None,
        seed: int = 0,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        self._match, self._dense = (samples, steps, extrinsic, smoothness, seed), (functions, refined)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        a, b = self._bases[i], self._bases[j]
        points = match(a, b, self._collection[i], self._collection[j], *self._match)
        return densified(a, b, points, *self._dense), densified(b, a, points.reversed(), *self._dense)
