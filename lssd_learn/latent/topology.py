"""Which pairs of a collection are mapped: undirected edge lists from distances between the shapes.

Every function returns an (m, 2) int array of pairs i < j, sorted, each once.
"""

import logging
from collections.abc import Iterable

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial.distance import cdist

from lssd_learn.errors import InputError

log = logging.getLogger(__name__)


def shape_dna_distances(evals: np.ndarray, areas: np.ndarray | None = None) -> np.ndarray:
    """Euclidean distances (n, n) between the spectra (n, k) of n shapes (Reuter et al. 2006).

    Eigenvalues shrink with area, so these are mostly distances between sizes; give the areas (n,) to compare the shapes
    as if each had unit area.
    """
    descriptors = np.asarray(evals, dtype=float)
    if areas is not None:
        descriptors = descriptors * np.asarray(areas)[:, None]
    return cdist(descriptors, descriptors)


def clique(n: int) -> np.ndarray:
    """Every pair."""
    return np.stack(np.triu_indices(n, 1), axis=1)


def chain(n: int) -> np.ndarray:
    """Consecutive pairs."""
    return np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)


def star(n: int, centre: int = 0) -> np.ndarray:
    """Every shape with shape `centre`."""
    if not 0 <= centre < n:
        raise InputError(f"centre={centre}: expected the number of a shape, 0 to {n - 1}")
    others = np.delete(np.arange(n), centre)
    return tidy(np.stack([np.full(n - 1, centre), others], axis=1))


def hubs(distances: np.ndarray, count: int) -> np.ndarray:
    """Every shape with `count` shapes that lie in the midst of the others.

    As many edges as `count` nearest neighbours, but no shape is further than two steps from any other. Hubs are chosen
    one by one, each the one that brings all shapes nearest to their own hub (k-medoids, the first phase of PAM).
    """
    n = len(distances)
    if not 1 <= count < n:
        raise InputError(f"hubs={count}: expected 1 to {n - 1} for {n} shapes")
    chosen, nearest_hub = [], np.full(n, distances.max())
    for _ in range(count):
        totals = np.minimum(distances, nearest_hub).sum(axis=1)
        totals[chosen] = np.inf
        chosen.append(int(totals.argmin()))
        nearest_hub = np.minimum(nearest_hub, distances[chosen[-1]])
    pairs = np.stack([np.repeat(chosen, n), np.tile(np.arange(n), count)], axis=1)
    return tidy(pairs[pairs[:, 0] != pairs[:, 1]])


def nearest(distances: np.ndarray, neighbours: int) -> np.ndarray:
    """Every shape with its `neighbours` nearest, whichever side is the near one.

    A graph that falls apart is joined by the edges of the minimum spanning tree, with a warning.
    """
    n = len(distances)
    if not 1 <= neighbours < n:
        raise InputError(f"neighbours={neighbours}: expected 1 to {n - 1} for {n} shapes")
    others = np.where(np.eye(n, dtype=bool), np.inf, distances)
    near = np.argsort(others, axis=1, kind="stable")[:, :neighbours]
    edges = tidy(np.stack([np.repeat(np.arange(n), neighbours), near.ravel()], axis=1))
    pieces = len(components(n, edges))
    if pieces > 1:
        log.warning(
            "the %d nearest neighbours leave %d pieces; joined by the minimum spanning tree", neighbours, pieces
        )
        edges = tidy(np.concatenate([edges, spanning_tree(distances)]))
    return edges


def spanning_tree(distances: np.ndarray) -> np.ndarray:
    """The minimum spanning tree."""
    # Ranks stand in for the distances: csgraph reads a distance of zero as no edge.
    ranks = np.unique(distances, return_inverse=True)[1].reshape(distances.shape) + 1.0
    tree = minimum_spanning_tree(np.triu(ranks, 1)).tocoo()
    return tidy(np.stack([tree.row, tree.col], axis=1))


def clusters(distances: np.ndarray, labels: Iterable) -> np.ndarray:
    """A minimum spanning tree within each cluster, and every shape linked to its nearest in each other cluster."""
    labels = np.asarray(list(labels))
    if len(labels) != len(distances):
        raise InputError(f"labels: expected one for each of the {len(distances)} shapes, got {len(labels)}")
    edges = []
    groups = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    for a, own in enumerate(groups):
        edges.append(own[spanning_tree(distances[np.ix_(own, own)])])
        for b, other in enumerate(groups):
            if a != b:
                near = other[distances[np.ix_(own, other)].argmin(axis=1)]
                edges.append(np.stack([own, near], axis=1))
    return tidy(np.concatenate(edges))


def tidy(edges: np.ndarray) -> np.ndarray:
    """The pairs (m, 2) in any order and direction as i < j, sorted, each once."""
    return np.unique(np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1), axis=0)


def components(n: int, edges: np.ndarray) -> list[np.ndarray]:
    """The connected components of a graph on n shapes, as arrays of shape numbers, the largest first."""
    edges = np.asarray(edges).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    return sorted((np.flatnonzero(label == c) for c in range(count)), key=len, reverse=True)
