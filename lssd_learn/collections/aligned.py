"""The shapes of a collection turned, shifted and, where need be, mirrored to lie alike: before any maps are computed.

How is found by `alignment/`, kept in the cache, and told in the log and in a table.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.alignment import ALIGN, VERSION, Lie, find, tell
from lssd_learn.collections.base import Collection
from lssd_learn.collections.folder import Folder
from lssd_learn.collections.given import as_collection
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.closest_points import angles
from lssd_learn.shapes.rigid import MIRROR

STAGE = "aligned"


class Aligned(Collection):
    """A collection laid alike. Vertices keep their numbers: landmarks, maps and parts stay what they are.

    The frame is that of one of the shapes, which stays as it lies: the one that most of the others need to be turned
    least for. A mirrored mesh has its faces turned over, so that its normals still point the way they did.

    Args:
        collection: n shapes.
        align: "rigid"; "auto" leaves the shapes as they lie where they are in vertex correspondence, lie alike already,
            or no turn lays them on each other; "none".
        mirror: "auto", "forbid" or "allow", see `shapes.rigid.rigid`.
        cache: where what is found is kept; None keeps it in memory.
        workers: see `in_parallel`.

    Raises:
        InputError: an argument out of its range.
    """

    def __init__(
        self,
        collection: Sequence[Shape],
        align: str = "rigid",
        mirror: str = "auto",
        cache: Cache | None = DEFAULT,
        workers: int | None = None,
    ):
        if align not in ALIGN:
            raise InputError(f"collection.align={align}: expected one of {', '.join(ALIGN)}")
        if mirror not in MIRROR:
            raise InputError(f"collection.mirror={mirror}: expected one of {', '.join(MIRROR)}")
        self.collection = collection = as_collection(collection)
        self.align, self.mirror = align, mirror
        self.names, self.up, self.groups = collection.names, collection.up, collection.groups
        self.parameters, self.parameter_names = collection.parameters, collection.parameter_names
        self.covariates = collection.covariates
        self.truth = collection.truth
        self.keep_in(cache, workers)

    def __getstate__(self):
        if self.align != "none":
            _ = self.lie  # found once, here, and not by every worker
        return vars(self)

    def __len__(self) -> int:
        return len(self.collection)

    def __getitem__(self, i: int) -> Shape:
        if self.align == "none":
            return self.collection[i]
        return laid(self.collection[i], self.lie.rotation[i], self.lie.shift[i])

    @property
    def landmarks(self) -> Sequence[Mapping[str, int]]:
        return self.collection.landmarks

    @property
    def vertex_maps(self) -> Mapping[tuple[int, int], np.ndarray]:
        return self.collection.vertex_maps

    @property
    def parts(self) -> Mapping[str, np.ndarray]:
        return self.collection.parts

    @property
    def key(self) -> str | None:
        whole = self.collection.key
        return whole if self.align == "none" or whole is None else fingerprint(STAGE, whole, self._how)

    def shape_key(self, i: int) -> str | None:
        """Depends on all shapes: they are laid on each other."""
        own = self.collection.shape_key(i)
        return own if self.align == "none" or own is None else fingerprint(STAGE, self._how, i)

    def check(self) -> Sequence[str]:
        return self.collection.check()

    @property
    def connectivities(self) -> Sequence[str | None] | None:
        return self.collection.connectivities

    def remind(self, warnings: Iterable[str]) -> None:
        self.collection.remind(warnings)

    def told(self) -> Sequence[str]:
        return self.collection.told()

    def lacks(self, what: str, name: str | None = None) -> str:
        return self.collection.lacks(what, name)

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self._cache, self._workers = cache, workers
        self.collection.keep_in(cache, workers)

    @cached_property
    def lie(self) -> Lie:
        """How the shapes were laid; found when first asked for."""

        def make() -> dict[str, np.ndarray]:
            return vars(find(self.collection, self.align, self.mirror, self._workers))

        if self.align == "none" or self._cache is None or self.collection.key is None:
            found = Lie(**make())
        else:
            found = Lie(**self._cache.get(STAGE, fingerprint(STAGE, self._how), make))
        tell(found, self.names, self.mirror)
        return found

    def marked(self, i: int) -> Mapping[str, np.ndarray]:
        marks = self.collection.marked(i)
        if self.align == "none" or not marks:
            return marks
        return {name: point @ self.lie.rotation[i] + self.lie.shift[i] for name, point in marks.items()}

    def changes(self) -> Sequence[Mapping[str, object]]:
        """How each shape was turned, and how well it lies."""
        if self.align == "none":
            return ()
        lie = self.lie
        return [
            {
                "name": name,
                "angle": float(angles(lie.rotation[i])),
                "mirrored": int(lie.mirrored[i]),
                "residual": float(lie.residual[i]),
                "residual_other_side": float(lie.other[i]),
                "residual_other_turn": float(lie.rival[i]),
                "missing": float(lie.missing[i]),
                "extra": float(lie.extra[i]),
                "of_the_kind": int(lie.fits[i]),
                "partial": int(lie.partial[i]),
            }
            for i, name in enumerate(self.names)
        ]

    def space(self, i: int) -> str:
        """Of a shape that was turned, none."""
        return self.collection.space(i) if self.align == "none" else ""

    @cached_property
    def _how(self) -> list:
        shapes = [self.collection.shape_key(i) for i in range(len(self))]
        return [VERSION, shapes, self.align, self.mirror]


class AlignedFolder(Aligned):
    """A folder of one's own shapes, laid alike: what `collection=folder` makes.

    Args:
        path, correspondence, groups, parameters, pieces, normalise_area, up, covariates, mask: see `Folder`.
        align, mirror: see `Aligned`.

    Raises:
        InputError: see `Folder` and `Aligned`.
    """

    def __init__(
        self,
        path: str | Path,
        correspondence: str = "auto",
        groups: Sequence[str] = (),
        parameters: Sequence[str] | None = None,
        pieces: str | None = None,
        normalise_area: bool = False,
        up: str | None = None,
        align: str = "none",
        mirror: str = "auto",
        covariates: Sequence[str] = (),
        mask: str | None = None,
    ):
        folder = Folder(path, correspondence, groups, parameters, pieces, normalise_area, up, covariates, mask)
        super().__init__(folder, align, mirror)


@dataclass(frozen=True, eq=False)
class _Laid(Mesh):
    """A mirrored mesh, whose vertices are still those of meshes that have the faces it had."""

    known_as: str | None = None

    @property
    def connectivity(self) -> str | None:
        return self.known_as


def laid(shape: Shape, rotation: np.ndarray, shift: np.ndarray) -> Shape:
    """A shape as `vertices @ rotation + shift`; the faces turned over where that mirrors it."""
    if np.array_equal(rotation, np.eye(3)) and not shift.any():
        return shape
    points = shape.vertices @ rotation + shift
    if isinstance(shape, PointCloud):
        return PointCloud(points)
    faces = shape.faces if np.linalg.det(rotation) > 0 else shape.faces[:, ::-1]
    return _Laid(points, faces, pieces=shape.pieces, known_as=shape.connectivity)
