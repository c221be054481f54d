"""The maps beside a folder of shapes, `maps/A__B.txt`: re-indexed to the cleaned shapes, and judged by smoothness.

Neighbours of one shape are mapped near each other by any map worth its name; one that counts from 1, or belongs to
other vertices, is off everywhere.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lssd_learn.collections.reading.listing import read_indices
from lssd_learn.collections.reading.shape import ReadShape
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.edges import edges

# Roughness, between 0 for a constant map and about 1 for a random one. That of a random map is refused where a smooth
# map would stay below SMOOTH; a warning is due at so many times what the two shapes' own edges explain.
RANDOM, SMOOTH, ROUGH = 0.5, 0.1, 4.0
NEIGHBOURS = 6  # of a point of a cloud


@dataclass(frozen=True, eq=False)
class VertexMaps(Mapping):
    """(a, b) → for each vertex of b the vertex of a, read from its file when asked for."""

    files: dict[tuple[int, int], Path]
    read: Callable[[int], ReadShape]
    told: Told

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self.files)

    def __getitem__(self, pair: tuple[int, int]) -> np.ndarray:
        a, b = pair
        return read_map(self.files[pair], self.read(a), self.read(b), self.told)


def read_map(file: Path, source: ReadShape, target: ReadShape, told: Told) -> np.ndarray:
    """(V_target',) a map file re-indexed to the cleaned shapes; where it leads to a dropped piece, the nearest vertex.

    Raises:
        InputError: no vertices of the source, not one for each of the target, counted from 1, or as good as random.
    """
    vertices = read_indices(file)
    n, a, b = len(source.original.points), Path(source.name).stem, Path(target.name).stem
    if len(vertices) != len(target.original.points):
        raise InputError(
            f"{file}: expected a vertex of {a} for each of the {len(target.original.points)} vertices of {b}, "
            f"got {len(vertices)}"
        )
    if vertices.min() < 0 or vertices.max() >= n:
        wrong = vertices.min() if vertices.min() < 0 else vertices.max()
        one = ": it counts from 1, take 1 off" if vertices.min() > 0 and vertices.max() == n else ""
        raise InputError(f"{file}: expected vertices of {a}, 0 to {n - 1}, got {wrong}{one}")
    check_smooth(file, vertices, source.original, target.original, told)
    vertices = vertices[target.vertex_index]
    mapped = source.new_index[vertices]
    lost = mapped < 0
    if lost.any():
        mapped[lost] = cKDTree(source.shape.points).query(source.original.points[vertices[lost]])[1]
        some = "1 vertex" if lost.sum() == 1 else f"{lost.sum():,} vertices"
        told.say(f"{file.name}: {some} led to a dropped piece, now to the nearest vertex kept")
    return mapped


def check_smooth(file: Path, vertices: np.ndarray, source: Shape, target: Shape, told: Told) -> None:
    """Refuse a map (V_target,) that takes neighbours anywhere; warn of one that is far rougher than the shapes.

    Raises:
        InputError: it is as rough as a random one, or much smoother if counted from 1.
    """
    pairs = _neighbours(target)
    own = roughness(source.points[vertices], pairs)
    # What a perfect map has: the steps between neighbours of the target, and those from vertex to vertex of the source.
    due = roughness(target.points, pairs) + roughness(source.points, _neighbours(source))
    if due > SMOOTH:
        return  # so few vertices that nothing is smooth
    if vertices.min() > 0 and own > 2 * due:
        before = roughness(source.points[vertices - 1], pairs)
        if before < own / 2:
            raise InputError(f"{file}: expected vertices counted from 0: counted from 1 the map is smooth, take 1 off")
    if own > RANDOM:
        hint = ""
        if len(source.points) == len(target.points) and len(np.unique(vertices)) == len(vertices):
            back = roughness(target.points[vertices], _neighbours(source))
            hint = "; it seems to be the map the other way round" * (back < max(ROUGH * due, own / 10))
        raise InputError(
            f"{file}: expected a map that takes neighbours to neighbours, it takes them anywhere, as a random one "
            f"would{hint}"
        )
    if own > ROUGH * due:
        told.warn(f"{file.name}: neighbours are mapped far apart, {np.sqrt(own / due):.0f} times as far as expected")


def roughness(points: np.ndarray, pairs: np.ndarray) -> float:
    """The mean square distance of pairs (E, 2) of points (V, 3), over that of points taken at random."""
    spread = 2 * points.var(axis=0).sum()
    if spread == 0:
        return 0.0
    start, end = points[pairs.T]
    return float(np.square(end - start).sum(axis=1).mean() / spread)


def _neighbours(shape: Shape) -> np.ndarray:
    """(E, 2) the edges of a mesh, or each point of a cloud with those next to it."""
    if isinstance(shape, Mesh):
        return edges(shape.faces)
    near = cKDTree(shape.points).query(shape.points, k=min(NEIGHBOURS + 1, len(shape.points)))[1]
    near = near.reshape(len(shape.points), -1)
    return np.stack([np.repeat(near[:, 0], near.shape[1] - 1), near[:, 1:].ravel()], axis=1)
