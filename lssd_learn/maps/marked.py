"""The computed maps that go by landmarks: `maps=landmarks`, `adjoint` and `spline`."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Int

from lssd_learn.collections import Collection
from lssd_learn.errors import check_whole
from lssd_learn.maps.adjoint import adjoint
from lssd_learn.maps.common_landmarks import SharedLandmarks, check_landmarks
from lssd_learn.maps.computed import ComputedMaps
from lssd_learn.maps.landmarks import Landmarks, landmark_vertices
from lssd_learn.maps.spline import Spline, spline_vertices
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)


class _MarkedMaps(ComputedMaps):
    """Those that go by landmarks: `landmarks` of those that two shapes share, see `SharedLandmarks`; None is all."""

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        landmarks: int | None = None,
        correspondence: str = "auto",
        **choices,
    ):
        super().__init__(bases, collection, correspondence, **choices)
        self._landmarks = landmarks

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, landmarks: int | None = None, **arguments) -> None:
        super().check(collection, every_pair, **arguments)
        check_landmarks(collection, landmarks, **arguments)

    @cached_property
    def _shared(self) -> SharedLandmarks:
        return SharedLandmarks(self._collection, self._landmarks)

    def depends_on(self, i: int, j: int) -> list:
        return [vertices.tolist() for vertices in self._shared.of_pair(i, j)]


class LandmarkMaps(_MarkedMaps):
    """`maps=landmarks`: from the landmarks that each two shapes of the collection share.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: how many of them to use, see `SharedLandmarks`; None is all.
        choices: see `landmarks.Landmarks`.

    Raises:
        InputError: on the first pair, fewer than three landmarks that two shapes share, or all of a shape on a line.
    """

    Choices = Landmarks
    how: Landmarks

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        return self._one_way(i, j), self._one_way(j, i)

    def _one_way(self, i: int, j: int) -> np.ndarray:
        return landmark_vertices(self._bases[i], self._bases[j], *self._shared.of_pair(i, j), self.how)


@dataclass(frozen=True)
class Adjoint:
    """The choices of `maps=adjoint`.

    Attributes:
        functions: that the pair of maps is computed for.
        trusted: of these, the ones that ZoomOut starts from.
        refined: functions at the end of ZoomOut; None leaves it out.

    Raises:
        InputError: a number out of its range.
    """

    functions: int = 60
    trusted: int = 30
    refined: int | None = 40

    def __post_init__(self):
        check_whole("maps.functions", self.functions, 1)
        check_whole("maps.trusted", self.trusted, 1, self.functions)


class AdjointMaps(_MarkedMaps):
    """`maps=adjoint`: both directions in one, regularised by each other; with landmarks where the collection has any.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`; 0 uses none.
        choices: see `Adjoint`.

    Raises:
        InputError: on the first pair, landmarks that do not do.
    """

    Choices = Adjoint
    how: Adjoint

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, landmarks: int | None = None, **arguments) -> None:
        if landmarks != 0 and any(collection.landmarks):
            super().check(collection, every_pair, landmarks, **arguments)
        else:
            cls._chosen(**arguments)

    @cached_property
    def _shared(self) -> SharedLandmarks | None:
        if self._landmarks == 0 or not any(self._collection.landmarks):
            log.warning("maps=adjoint: without landmarks; symmetric shapes may be mapped mirrored")
            return None
        return SharedLandmarks(self._collection, self._landmarks)

    def _marks(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        none = np.empty(0, dtype=int)
        return (none, none) if self._shared is None else self._shared.of_pair(i, j)

    def depends_on(self, i: int, j: int) -> list:
        return [vertices.tolist() for vertices in self._marks(i, j)]

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        a, b = (basis.truncate(min(self.how.functions, basis.k)) for basis in (self._bases[i], self._bases[j]))
        few = self.how.trusted
        there, back = (C[:few, :few] for C in adjoint(a, b, *self._marks(i, j)))
        return zoomed_vertices(a, b, there, self.how.refined), zoomed_vertices(b, a, back, self.how.refined)


class SplineMaps(_MarkedMaps):
    """`maps=spline`: from landmarks in space, for rigid shapes of one kind, such as bones.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`.
        choices: see `spline.Spline`.

    Raises:
        InputError: on the first pair, fewer than four landmarks that two shapes share, or all of a shape in a plane.
    """

    Choices = Spline
    how: Spline

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        shapes = self._collection
        return spline_vertices(shapes[i], shapes[j], *self._shared.of_pair(i, j), self.how)
