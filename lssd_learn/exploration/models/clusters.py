"""Threshold-free cluster enhancement: a point counts by how high it is and how wide the region is that it stands in.

Source: Smith & Nichols, "Threshold-free cluster enhancement", NeuroImage 44 (2009).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.edges import edges
from lssd_learn.shapes.geodesics import graph
from lssd_learn.shapes.sampling import farthest_points

STEP, STEPS = 0.25, 40  # of the thresholds; a statistic above the last counts as that
HEIGHT, EXTENT = 2.0, 1.0  # powers of threshold and area, those proposed for surfaces
POINTS = 600  # that stand for the surface: fields are smooth
NEAREST = 3  # of them that tell a vertex its value


@dataclass(frozen=True, eq=False)
class Cells:
    """A surface as c points, each with what lies nearest to it.

    Attributes:
        chosen: (c,) vertices.
        area: (c,) shares of the whole.
        borders: (e, 2) cells that touch.
        carry: (V, c) rows of sum 1: a vertex has the mean of the values of the points that are nearest to it.
    """

    chosen: Int[np.ndarray, " c"]
    area: Float[np.ndarray, " c"]
    borders: Int[np.ndarray, "e 2"]
    carry: csr_array

    @classmethod
    def of(cls, shape: Shape, points: int = POINTS) -> "Cells":
        """Spread-out points of a shape, all its vertices where there are no more; paths along its surface.

        Args:
            shape: a mesh, or a cloud, of which all points count the same.
            points: how many.
        """
        V, joined = len(shape.vertices), graph(shape)
        chosen = np.arange(V) if points >= V else farthest_points(shape.vertices, points)
        _, _, sources = dijkstra(joined, directed=False, indices=chosen, min_only=True, return_predecessors=True)
        of = np.full(V, -1)
        of[chosen] = np.arange(len(chosen))
        cell = np.where(sources < 0, -1, of[np.clip(sources, 0, None)])
        mass = shape.vertex_areas if isinstance(shape, Mesh) else np.ones(V)
        area = np.bincount(cell[cell >= 0], mass[cell >= 0], len(chosen)) / mass.sum()
        a, b = edges(shape.faces).T if isinstance(shape, Mesh) else np.stack(coo_array(joined).coords)
        a, b = cell[a], cell[b]
        across = (a != b) & (a >= 0) & (b >= 0)
        borders = np.unique(np.sort(np.column_stack([a, b])[across], axis=1), axis=0)
        many = min(NEAREST, len(chosen))
        far, near = cKDTree(shape.vertices[chosen]).query(shape.vertices, k=many)
        far, near = far.reshape(V, many), near.reshape(V, many)
        weight = 1 / np.maximum(far, 1e-9 * np.ptp(shape.vertices))
        weight /= weight.sum(1, keepdims=True)
        starts = np.arange(V + 1) * many
        return cls(chosen, area, borders, csr_array((weight.ravel(), near.ravel(), starts), shape=(V, len(chosen))))


def enhanced(values: Float[np.ndarray, "r c"], cells: Cells) -> Float[np.ndarray, "r c"]:
    """Σ_h a(h)^E h^H Δh (r, c), a(h) the area of the connected region above h that a point stands in.

    Regions of both signs are apart from each other.

    Args:
        values: r maps of a statistic, such as t, at the points.
        cells: of the surface.
    """
    r, c = values.shape
    steps = np.minimum(np.abs(values) / STEP, STEPS).astype(int)
    first, second = cells.borders.T
    alike = np.sign(values[:, first]) == np.sign(values[:, second])
    shared = np.where(alike, np.minimum(steps[:, first], steps[:, second]), 0)
    found = np.zeros((r, c))
    for step in range(1, int(steps.max(initial=0)) + 1):
        maps = np.flatnonzero((steps >= step).any(1))  # the high thresholds are of few maps
        there, (row, edge) = steps[maps] >= step, np.nonzero(shared[maps] >= step)
        links = coo_array((np.ones(len(row), dtype=bool), (row * c + first[edge], row * c + second[edge])),
                          shape=(len(maps) * c,) * 2)  # fmt: skip
        _, label = connected_components(links.tocsr(), directed=False)
        areas = np.bincount(label, np.where(there, cells.area, 0.0).ravel())[label].reshape(there.shape)
        found[maps] += np.where(there, areas**EXTENT, 0.0) * (step * STEP) ** HEIGHT * STEP
    return found
