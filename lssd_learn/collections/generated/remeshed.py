"""The shapes of another collection as if each had been scanned by itself: every one a mesh, or a cloud, of its own.

For methods that map shapes without correspondences: here the true maps are known.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from operator import index

import numpy as np
from scipy.sparse.csgraph import dijkstra

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.made_of import MadeOf
from lssd_learn.collections.turned import check_turned, turned_shape
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.edges import edges
from lssd_learn.shapes.geodesics import graph
from lssd_learn.shapes.remesh import remesh
from lssd_learn.shapes.sampling import farthest_points, sample_with_corners

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other shapes: it is part of the cache key
KINDS = ("mesh", "cloud")
REMEMBERED = 256  # shapes a process keeps, under a megabyte each: of a network each is asked for once an edge


class Remeshed(MadeOf):
    """Every shape of `base` with a connectivity of its own, or none.

    Args:
        base: meshes in vertex correspondence, such as `Bodies`.
        kind: "mesh", see `remesh`; "cloud", points that are independent and uniform by area.
        vertices: of a shape, drawn evenly from this interval (least, most); where a mesh is to have more than that of
            `base`, every triangle of that is divided into four first.
        seed: shape i is made from the stream (seed, i).
        marks: as many landmarks are known on every shape, spread over the first shape of `base`; 0 for none.
        turned: how each shape lies: "none" as in `base`, "vertical" turned at random about z, "any" by any rotation.

    Attributes:
        vertex_maps: (a, b) → the true map, for every pair: for each vertex of b the vertex of a nearest to where the
            same point of `base` lies on a.
        names, parameters, parameter_names, groups, up: those of `base`; up is None where shapes lie anyhow.
        landmarks: where `marks` are asked for; makes shape 0.

    Raises:
        InputError: an argument out of its range; when a shape is asked for, shapes that are not in correspondence or
            have too few vertices.
    """

    truth = True

    def __init__(
        self,
        base: Collection,
        kind: str = "mesh",
        vertices: Sequence[int] = (5000, 8000),
        seed: int = 0,
        marks: int = 0,
        turned: str = "none",
    ):
        if kind not in KINDS:
            raise InputError(f"collection.kind={kind}: expected one of {', '.join(KINDS)}")
        check_turned(turned)
        if len(vertices) != 2:
            raise InputError(f"collection.vertices={list(vertices)}: expected two numbers, the least and the most")
        check_whole("collection.vertices", vertices[0], 4)
        check_whole("collection.vertices", vertices[1], vertices[0])
        check_whole("collection.seed", seed, 0)
        check_whole("collection.marks", marks, 0)
        super().__init__(base)
        self.kind, self.seed = kind, int(seed)
        self.vertices = (int(vertices[0]), int(vertices[1]))
        self.marks, self.turned = int(marks), turned
        if turned == "any":
            self.up = None
        self.key = None if base.key is None else self._key(base.key, self.marks)
        self.vertex_maps = _TrueMaps(self)

    def __getitem__(self, i: int) -> Shape:
        return self._made(i)[0]

    def shape_key(self, i: int) -> str | None:
        """Does not depend on the landmarks, nor on the other shapes."""
        key = self.base.shape_key(i)
        return None if key is None else self._key(key)

    def origins(self, i: int) -> np.ndarray:
        """(V_i,) for each vertex of shape i the vertex of `base` that it stands beside."""
        return self._made(i)[1]

    def nearest(self, i: int) -> np.ndarray:
        """(V_base,) for each vertex of `base` the vertex of shape i nearest to it, along the surface."""
        return self._made(i)[2]

    @property
    def landmarks(self) -> Sequence[Mapping[str, int]]:
        """Of each shape, name → vertex."""
        if not self.marks:
            return ()
        at = farthest_points(self.base[0].vertices, self.marks)
        return [{f"mark_{m}": int(self.nearest(i)[v]) for m, v in enumerate(at)} for i in range(len(self))]

    def _key(self, of: str, *more) -> str:
        how = [] if self.turned == "none" else ["turned", self.turned]  # without, the key is the one from before
        return fingerprint("Remeshed", GENERATOR_VERSION, of, self.kind, list(self.vertices), self.seed, *how, *more)

    def _made(self, i: int) -> tuple[Shape, np.ndarray, np.ndarray]:
        i = range(len(self))[index(i)]
        if self.base.key is None:
            return _make(self, i)
        return _remembered(_Request(self, i))


class _Request:
    """Shape i of a collection, the same whenever the cache knows it by the same key."""

    def __init__(self, collection: Remeshed, i: int):
        self.collection, self.i, self.key = collection, i, collection.shape_key(i)

    def __hash__(self) -> int:
        return hash((self.key, self.i))

    def __eq__(self, other) -> bool:
        return (self.key, self.i) == (other.key, other.i)


@lru_cache(REMEMBERED)
def _remembered(request: _Request) -> tuple[Shape, np.ndarray, np.ndarray]:
    return _make(request.collection, request.i)


def _make(collection: Remeshed, i: int) -> tuple[Shape, np.ndarray, np.ndarray]:
    """Shape i, its origins and the way back."""
    base, (least, most) = collection.base, collection.vertices
    mesh = base[i]
    if not isinstance(mesh, Mesh):
        raise InputError(f"{base.names[i]}: expected a mesh to remesh, got a cloud")
    rng = np.random.default_rng([collection.seed, i])
    count = int(rng.integers(least, most + 1))
    if collection.kind == "cloud":
        points, origins = sample_with_corners(mesh, count, rng)
        shape = PointCloud(points)
    else:
        fine, beside = (mesh, np.arange(len(mesh.vertices))) if count <= len(mesh.vertices) else _divided(mesh)
        if count > len(fine.vertices):
            raise InputError(
                f"collection.vertices={list(collection.vertices)}: expected at most {len(fine.vertices)}, those of "
                f"{base.names[i]} with every triangle divided into four"
            )
        made = remesh(fine, count, rng)
        shape, origins = made.mesh, beside[made.origins]
    return turned_shape(shape, collection.turned, collection.seed, i), origins, _way_back(mesh, shape, origins)


def _divided(mesh: Mesh) -> tuple[Mesh, np.ndarray]:
    """The same surface, of every triangle four, and for each vertex one of `mesh` beside it: itself, or an end of the
    edge that it halves."""
    count, every = len(mesh.vertices), edges(mesh.faces)
    halves = mesh.vertices[every].mean(axis=1)
    a, b, c = mesh.faces.T
    codes = every[:, 0] * count + every[:, 1]
    ab, bc, ca = (
        count + np.searchsorted(codes, np.minimum(i, j) * count + np.maximum(i, j)) for i, j in ((a, b), (b, c), (c, a))
    )
    quarters = [np.stack(corners, axis=1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    beside = np.concatenate([np.arange(count), every[:, 0]])
    return Mesh(np.concatenate([mesh.vertices, halves]), np.concatenate(quarters)), beside


def _way_back(mesh: Mesh, shape: Shape, origins: np.ndarray) -> np.ndarray:
    """(V,) for each vertex of `mesh` the vertex of `shape` beside the nearest vertex that has one."""
    away = np.linalg.norm(shape.vertices - mesh.vertices[origins], axis=1)
    order = np.lexsort([away, origins])  # of several beside one vertex the nearest
    starts, first = np.unique(origins[order], return_index=True)
    beside = np.full(len(mesh.vertices), -1)
    beside[starts] = order[first]
    _, _, sources = dijkstra(graph(mesh), directed=False, indices=starts, return_predecessors=True, min_only=True)
    return beside[sources]


class _TrueMaps(Mapping):
    """(a, b) → for each vertex of b the vertex of a; made when asked for."""

    def __init__(self, collection: Remeshed):
        self._collection = collection

    def __len__(self) -> int:
        return len(self._collection) * (len(self._collection) - 1)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        n = len(self._collection)
        return ((a, b) for a in range(n) for b in range(n) if a != b)

    def __contains__(self, pair) -> bool:
        a, b = pair
        return a != b and min(a, b) >= 0 and max(a, b) < len(self._collection)

    def __getitem__(self, pair: tuple[int, int]) -> np.ndarray:
        if pair not in self:
            raise KeyError(pair)
        a, b = pair
        return self._collection.nearest(a)[self._collection.origins(b)]
