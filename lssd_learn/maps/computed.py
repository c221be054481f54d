"""The maps of a collection whose shapes are not in correspondence, computed pair by pair: at once or as asked for.

Where a correspondence is known, `correspondence="none"` computes them all the same: to see what they are worth.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.maps.adjoint import adjoint
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.kernel_matching import matched_vertices
from lssd_learn.maps.landmarks import landmark_vertices
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.maps.registration import from_afar, nearest_vertices, registered
from lssd_learn.maps.spline import spline_vertices
from lssd_learn.maps.stored import StoredMaps
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)


class ComputedMaps(PairMaps):
    """Vertex identity between shapes of one connectivity, computed maps elsewhere: both directions of a pair at once.

    The vertex maps of the collection are not used. Subclasses give `vertex_maps`, and `depends_on` where a pair's maps
    depend on more than its two shapes.

    Args:
        bases, collection: see `PairMaps`.
        correspondence: "auto", or "none": shapes of one connectivity are no exception.

    Raises:
        InputError: another correspondence.
    """

    version = 1  # goes up whenever the same two shapes and arguments give other maps: it is part of the cache key
    computed = True

    def __init__(self, bases: Sequence[Eigenbasis], collection: Collection, correspondence: str = "auto"):
        super().__init__(bases, collection)
        if correspondence not in ("auto", "none"):
            raise InputError(f"maps.correspondence={correspondence}: expected auto or none")
        self._ignored = correspondence == "none"
        self._stored = StoredMaps()

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
        on_b, on_a = self._stored(self, min(i, j), max(i, j))  # whichever direction is asked for first
        return from_correspondence(self._bases[i], self._bases[j], on_b if i < j else on_a)

    def prepare(self, pairs: Iterable[tuple[int, int]], workers: int | None = None) -> None:
        wanted = sorted({(min(pair), max(pair)) for pair in pairs if not self._correspond(*pair)})
        self._stored.prepare(self, wanted, workers)

    def keep_in(self, cache: Cache, key: Callable[[int, int, list], str]) -> None:
        self._stored = StoredMaps(cache, key)

    def depends_on(self, i: int, j: int) -> list:
        """What the maps of a pair depend on beside its two shapes, in plain words and numbers."""
        return []


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

    def depends_on(self, i: int, j: int) -> list:
        return [self._vertices[i].tolist(), self._vertices[j].tolist()]

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

    def depends_on(self, i: int, j: int) -> list:
        return [self._vertices[i].tolist(), self._vertices[j].tolist()]

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        a, b = (basis.truncate(min(self._functions, basis.k)) for basis in (self._bases[i], self._bases[j]))
        there, back = (C[: self._trusted, : self._trusted] for C in adjoint(a, b, self._vertices[i], self._vertices[j]))
        return zoomed_vertices(a, b, there, self._refined), zoomed_vertices(b, a, back, self._refined)


class RegistrationMaps(ComputedMaps):
    """`maps=registration`: the one shape bent onto the other, for shapes that stand alike.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        rounds, functions: see `registration.registration`.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        rounds: int = 12,
        functions: int = 80,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        self._sizes = from_afar(rounds, functions)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        a, b, shapes = self._bases[i], self._bases[j], (self._collection[i], self._collection[j])
        return registered(a, b, *shapes, *nearest_vertices(a, b, *shapes), self._sizes)


class KernelMatchingMaps(ComputedMaps):
    """`maps=kernel_matching`: nothing but the shapes is needed, standing upright and facing one way.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        samples, steps, extrinsic, smoothness, functions, refined, registered, seed: see
            `kernel_matching.kernel_matching`.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        samples: int = 300,
        steps: int = 8,
        extrinsic: float = 1.0,
        smoothness: float = 1.0,
        functions: int = 30,
        refined: int | None = None,
        registered: int = 12,
        seed: int = 0,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        self._match, self._dense = (samples, steps, extrinsic, smoothness, seed), (functions, refined, registered)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        a, b, shapes = self._bases[i], self._bases[j], self._collection
        return matched_vertices(a, b, shapes[i], shapes[j], self._match, self._dense)


class SplineMaps(ComputedMaps):
    """`maps=spline`: from landmarks in space, for rigid shapes of one kind, such as bones.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`.
        rounds, samples: see `spline.spline_vertices`.

    Raises:
        InputError: on the first pair, fewer than four landmarks that all shapes have, or all of a shape in a plane.
    """

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        landmarks: int | None = None,
        rounds: int = 6,
        samples: int = 400,
        correspondence: str = "auto",
    ):
        super().__init__(bases, collection, correspondence)
        self._landmarks, self._how = landmarks, (rounds, samples)

    @cached_property
    def _vertices(self) -> np.ndarray:
        return common_landmarks(self._collection, self._landmarks)

    def depends_on(self, i: int, j: int) -> list:
        return [self._vertices[i].tolist(), self._vertices[j].tolist()]

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        shapes, marks = self._collection, self._vertices
        return spline_vertices(shapes[i], shapes[j], marks[i], marks[j], *self._how)
