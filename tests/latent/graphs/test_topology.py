"""The pairs that are mapped, against slow and obvious twins."""

import logging
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist

from lssd_learn.errors import InputError
from lssd_learn.latent.graphs import topology
from lssd_learn.latent.graphs.near import nearest as nearest_points


@st.composite
def points(draw, least=2):
    """Points with small whole coordinates: many ties, and shapes that are there twice."""
    n = draw(st.integers(least, 40))
    return np.array(draw(st.lists(st.tuples(*[st.integers(0, 6)] * 2), min_size=n, max_size=n)), dtype=float)


def spectra(n, seed=0, apart=0.0):
    """Points as shapes have them: many coordinates, few of them free; in two groups if `apart`."""
    rng = np.random.default_rng(seed)
    free = rng.normal(size=(n, 4))
    free[: n // 2, 0] += apart
    return np.sort(np.arange(30) * 5 * (1 + 0.05 * free[:, :1]) + np.tanh(free @ rng.normal(size=(4, 30))), axis=1)


def dense_nearest(D, p):
    """The old way: all distances, sorted."""
    n = len(D)
    near = np.argsort(np.where(np.eye(n, dtype=bool), np.inf, D), axis=1, kind="stable")[:, :p]
    return topology.tidy(np.stack([np.repeat(np.arange(n), p), near.ravel()], axis=1))


def dense_tree(D):
    tree = minimum_spanning_tree(np.triu(D, 1)).tocoo()
    return topology.tidy(np.stack([tree.row, tree.col], axis=1))


@pytest.mark.parametrize("apart", [0.0, 50.0])
@pytest.mark.parametrize("seed", range(3))
def test_no_topology_differs_from_the_one_of_all_distances(seed, apart):
    X = spectra(300, seed, apart)
    D = cdist(X, X)
    tree = dense_tree(D)
    np.testing.assert_array_equal(topology.spanning_tree(X), tree)
    for p in (1, 7, 20):
        expected = dense_nearest(D, p)
        if len(topology.components(300, expected)) > 1:
            expected = topology.tidy(np.concatenate([expected, tree]))
        np.testing.assert_array_equal(topology.nearest(X, p), expected)


@given(X=points(), count=st.integers(1, 5), apart=st.booleans())
@settings(max_examples=60, deadline=None)
def test_equally_near_ones_are_taken_by_number(X, count, apart):
    D = cdist(X, X)
    if apart:
        numbers, away = nearest_points(X, X, min(count, len(X)))
    else:
        count = min(count, len(X) - 1)
        numbers, away = nearest_points(X, X, count, own=True)
        D[np.eye(len(X), dtype=bool)] = np.inf
    expected = np.argsort(D, axis=1, kind="stable")[:, :count]
    np.testing.assert_array_equal(numbers, expected)
    np.testing.assert_array_equal(away, np.take_along_axis(D, expected, axis=1))


def test_memory_grows_with_the_number_of_shapes():
    X = spectra(3000)
    tracemalloc.start()
    try:
        topology.nearest(X, 20)
        topology.spanning_tree(X)
        topology.clusters(X, np.arange(3000) % 3)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 3000 * 3000 * 8 / 3  # a third of all distances


def test_hubs_are_those_of_all_distances(monkeypatch):
    monkeypatch.setattr("lssd_learn.latent.graphs.near.ENTRIES", 500)  # rows by the few
    X = spectra(60)
    D = cdist(X, X)
    first = int(D.sum(axis=1).argmin())
    second = int(np.minimum(D, D[first]).sum(axis=1).argmin())
    degrees = np.bincount(topology.hubs(X, 2).ravel())
    assert set(np.flatnonzero(degrees == 59)) == {first, second}


def pairs(edges):
    return {tuple(edge) for edge in edges.tolist()}


def reached(n, edges):
    """The components, by walking."""
    left, found = set(range(n)), []
    while left:
        front = {left.pop()}
        piece = set()
        while front:
            piece |= front
            front = {b for e in edges for a, b in (e, e[::-1]) if a in front} - piece
        left -= piece
        found.append(piece)
    return found


def kruskal(D):
    """The total length of a minimum spanning tree."""
    n, total = len(D), 0.0
    piece = list(range(n))
    for length, i, j in sorted((D[a, b], a, b) for a in range(n) for b in range(a)):
        if piece[i] != piece[j]:
            total += length
            old = piece[j]
            piece = [piece[i] if p == old else p for p in piece]
    return total


def is_tidy(n, edges):
    assert edges.ndim == 2
    assert edges.shape[1] == 2
    assert edges.dtype == np.int64
    assert (edges[:, 0] < edges[:, 1]).all()
    assert edges.min() >= 0
    assert edges.max() < n
    assert edges.tolist() == sorted(map(list, pairs(edges)))


@given(X=points(), seed=st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_every_topology_is_connected_and_lists_each_pair_once(X, seed):
    n = len(X)
    labels = np.random.default_rng(seed).integers(0, 3, n)
    made = [topology.clique(n), topology.chain(n), topology.star(n, seed % n), topology.spanning_tree(X)]
    made += [topology.nearest(X, 1 + seed % (n - 1)), topology.clusters(X, labels)]
    for edges in made:
        is_tidy(n, edges)
        assert len(reached(n, pairs(edges))) == 1
    assert [len(edges) for edges in made[:4]] == [n * (n - 1) // 2, n - 1, n - 1, n - 1]


@given(X=points())
@settings(max_examples=60, deadline=None)
def test_the_spanning_tree_is_as_short_as_kruskals(X):
    D = cdist(X, X)
    i, j = topology.spanning_tree(X).T
    assert D[i, j].sum() == pytest.approx(kruskal(D))


@given(X=points(least=3), p=st.integers(1, 11))
@settings(max_examples=60, deadline=None)
def test_nearest_neighbours_are_those_of_either_side(X, p):
    n, D = len(X), cdist(X, X)
    p = min(p, n - 1)
    expected = set()
    for i in range(n):
        others = sorted((D[i, j], j) for j in range(n) if j != i)[:p]
        expected |= {tuple(sorted((i, j))) for _, j in others}
    edges = pairs(topology.nearest(X, p))
    if len(reached(n, expected)) > 1:
        assert expected < edges
        expected |= pairs(topology.spanning_tree(X))
    assert edges == expected


@given(X=points(), scale=st.floats(1e-3, 1e3))
@settings(max_examples=20, deadline=None)
def test_units_do_not_matter(X, scale):
    scale = 2.0 ** round(np.log2(scale))  # so that rescaling neither makes nor breaks a tie
    assert pairs(topology.nearest(scale * X, 1)) == pairs(topology.nearest(X, 1))
    assert pairs(topology.spanning_tree(scale * X)) == pairs(topology.spanning_tree(X))


def test_two_far_groups_are_joined_with_a_warning(caplog):
    with caplog.at_level(logging.WARNING):
        edges = topology.nearest(np.array([0, 1, 2, 100, 101, 102.0])[:, None], 1)
    assert (2, 3) in pairs(edges)
    assert "the 1 nearest neighbours leave 2 pieces; joined by the minimum spanning tree" in caplog.text


def test_duplicate_shapes_are_linked_at_distance_zero():
    X = np.zeros((4, 2))
    assert len(topology.spanning_tree(X)) == 3
    assert len(reached(4, pairs(topology.nearest(X, 1)))) == 1
    X[3] = [3, 4]
    assert len(pairs(topology.spanning_tree(X)) & {(0, 3), (1, 3), (2, 3)}) == 1


@given(X=points(least=3), seed=st.integers(0, 99))
@settings(max_examples=40, deadline=None)
def test_clusters_are_trees_and_nearest_links(X, seed):
    n, D = len(X), cdist(X, X)
    labels = np.random.default_rng(seed).integers(0, 2, n)
    edges = pairs(topology.clusters(X, labels))
    within = {e for e in edges if labels[e[0]] == labels[e[1]]}
    for label in set(labels):
        own = np.flatnonzero(labels == label)
        tree = [e for e in within if labels[e[0]] == label]
        assert len(tree) == len(own) - 1
        assert sum(D[e] for e in tree) == pytest.approx(kruskal(D[np.ix_(own, own)]))
    if len(set(labels)) == 2:
        for i in range(n):
            nearest = D[i][labels != labels[i]].min()
            assert any(i in e and D[e] == nearest for e in edges - within)


def test_labels_of_any_kind_serve():
    X = np.arange(5.0)[:, None]
    expected = topology.clusters(X, [0, 0, 1, 1, 1])
    for labels in ("aabbb", ["cat", "cat", "dog", "dog", "dog"], iter([True, True, False, False, False])):
        np.testing.assert_array_equal(topology.clusters(X, labels), expected)


def test_shape_dna_is_the_spectrum_and_free_of_size_where_areas_are_given():
    rng = np.random.default_rng(0)
    evals, areas = rng.random((5, 7)), rng.random(5)
    np.testing.assert_array_equal(topology.shape_dna(evals), evals)
    scales = rng.random(5) + 0.5
    unit = topology.shape_dna(evals, areas)
    np.testing.assert_allclose(topology.shape_dna(evals / scales[:, None] ** 2, areas * scales**2), unit, atol=1e-12)


@given(n=st.integers(1, 9), edges=st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), max_size=9))
@settings(max_examples=50, deadline=None)
def test_components_are_those_found_by_walking(n, edges):
    edges = [(a % n, b % n) for a, b in edges]
    found = topology.components(n, edges)
    assert sorted(map(tuple, found)) == sorted(tuple(sorted(piece)) for piece in reached(n, edges))
    assert [len(piece) for piece in found] == sorted(map(len, found), reverse=True)


def test_borders():
    X = np.zeros((4, 2))
    for neighbours in (0, 4):
        with pytest.raises(InputError, match=f"neighbours={neighbours}: expected 1 to 3 for 4 shapes"):
            topology.nearest(X, neighbours)
    for centre in (-1, 4):
        with pytest.raises(InputError, match=f"centre={centre}: expected the number of a shape, 0 to 3"):
            topology.star(4, centre)
    with pytest.raises(InputError, match="labels: expected one for each of the 4 shapes, got 3"):
        topology.clusters(X, "aab")


def test_hubs_lie_in_the_midst_and_join_everything():
    places = np.array([0.0, 1, 2, 10, 11, 12, 100])[:, None]
    (one,) = (set(np.bincount(topology.hubs(places, 1).ravel()).argsort()[-1:]),)
    assert one == {3}
    pairs = topology.hubs(places, 2)
    assert len(pairs) == 6 + 6 - 1
    degrees = np.bincount(pairs.ravel())
    assert sorted(degrees)[-2:] == [6, 6]
    assert degrees[6] == 6  # the far one has no other near
    with pytest.raises(InputError, match="hubs=7: expected 1 to 6 for 7 shapes"):
        topology.hubs(places, 7)
