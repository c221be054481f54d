"""Which pairs of a collection are mapped: undirected edge lists, where need be from points (n, d) whose distances
are those of the shapes: see `shape_dna`. No function holds the distances of all pairs.

Every function returns an (m, 2) int array of pairs i < j, sorted, each once.
"""

import logging
from collections.abc import Iterable

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from lssd_learn.errors import InputError
from lssd_learn.latent.graphs.medoids import medoids
from lssd_learn.latent.graphs.near import nearest as nearest_points
from lssd_learn.latent.graphs.tree import spanning_tree as tree_of

log = logging.getLogger(__name__)


def shape_dna(
    evals: Float[np.ndarray, "n k"], areas: Float[np.ndarray, " n"] | None = None
) -> Float[np.ndarray, "n k"]:
    """Points (n, k) whose distances are those of n shapes: their spectra (n, k) (Reuter et al. 2006).

    Eigenvalues shrink with area, so these are mostly distances between sizes; give the areas (n,) to compare the shapes
    as if each had unit area.
    """
    points = np.asarray(evals, dtype=float)
    return points if areas is None else points * np.asarray(areas)[:, None]


def clique(n: int) -> Int[np.ndarray, "m 2"]:
    """Every pair."""
    return np.stack(np.triu_indices(n, 1), axis=1)


def chain(n: int) -> Int[np.ndarray, "m 2"]:
    """Consecutive pairs."""
    return np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)


def star(n: int, centre: int = 0) -> Int[np.ndarray, "m 2"]:
    """Every shape with shape `centre`."""
    if not 0 <= centre < n:
        raise InputError(f"centre={centre}: expected the number of a shape, 0 to {n - 1}")
    others = np.delete(np.arange(n), centre)
    return tidy(np.stack([np.full(n - 1, centre), others], axis=1))


def hubs(points: Float[np.ndarray, "n d"], count: int) -> Int[np.ndarray, "m 2"]:
    """Every shape with `count` shapes that lie in the midst of the others.

    As many edges as `count` nearest neighbours, but no shape is further than two steps from any other. Hubs are chosen
    one by one, each the one that brings all shapes nearest to their own hub, see `medoids`.
    """
    n = len(points)
    if not 1 <= count < n:
        raise InputError(f"hubs={count}: expected 1 to {n - 1} for {n} shapes")
    chosen = medoids(points, count)
    pairs = np.stack([np.repeat(chosen, n), np.tile(np.arange(n), count)], axis=1)
    return tidy(pairs[pairs[:, 0] != pairs[:, 1]])


def nearest(points: Float[np.ndarray, "n d"], neighbours: int) -> Int[np.ndarray, "m 2"]:
    """Every shape with its `neighbours` nearest, whichever side is the near one.

    A graph that falls apart is joined by the edges of the minimum spanning tree, with a warning.
    """
    n = len(points)
    if not 1 <= neighbours < n:
        raise InputError(f"neighbours={neighbours}: expected 1 to {n - 1} for {n} shapes")
    near, _ = nearest_points(points, points, neighbours, own=True)
    edges = tidy(np.stack([np.repeat(np.arange(n), neighbours), near.ravel()], axis=1))
    pieces = len(components(n, edges))
    if pieces > 1:
        log.warning(
            "the %d nearest neighbours leave %d pieces; joined by the minimum spanning tree", neighbours, pieces
        )
        edges = tidy(np.concatenate([edges, spanning_tree(points)]))
    return edges


def spanning_tree(points: Float[np.ndarray, "n d"]) -> Int[np.ndarray, "m 2"]:
    """The minimum spanning tree; of several of one length the same one every time."""
    return tidy(tree_of(points))


def clusters(points: Float[np.ndarray, "n d"], labels: Iterable) -> Int[np.ndarray, "m 2"]:
    """A minimum spanning tree within each cluster, and every shape linked to its nearest in each other cluster."""
    labels = np.asarray(list(labels))
    if len(labels) != len(points):
        raise InputError(f"labels: expected one for each of the {len(points)} shapes, got {len(labels)}")
    edges = []
    groups = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    for a, own in enumerate(groups):
        edges.append(own[spanning_tree(points[own])])
        for b, other in enumerate(groups):
            if a != b:
                near, _ = nearest_points(points[own], points[other], 1)
                edges.append(np.stack([own, other[near[:, 0]]], axis=1))
    return tidy(np.concatenate(edges))


def tidy(edges: ArrayLike) -> Int[np.ndarray, "m 2"]:
    """The pairs (m, 2) in any order and direction as i < j, sorted, each once."""
    return np.unique(np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1), axis=0)


def components(n: int, edges: ArrayLike) -> list[Int[np.ndarray, " c"]]:
    """The connected components of a graph on n shapes, as arrays of shape numbers, the largest first."""
    edges = np.asarray(edges).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    return sorted((np.flatnonzero(label == c) for c in range(count)), key=len, reverse=True)
