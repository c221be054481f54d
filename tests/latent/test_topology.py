"""The pairs that are mapped, against slow and obvious twins."""

import logging

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.latent import topology


@st.composite
def distances(draw, least=2):
    """Distances of points with small whole coordinates: many ties, and shapes that are there twice."""
    n = draw(st.integers(least, 12))
    points = np.array(draw(st.lists(st.tuples(*[st.integers(0, 4)] * 2), min_size=n, max_size=n)), dtype=float)
    return np.linalg.norm(points[:, None] - points[None], axis=2)


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


@given(D=distances(), seed=st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_every_topology_is_connected_and_lists_each_pair_once(D, seed):
    n = len(D)
    labels = np.random.default_rng(seed).integers(0, 3, n)
    made = [topology.clique(n), topology.chain(n), topology.star(n, seed % n), topology.spanning_tree(D)]
    made += [topology.nearest(D, 1 + seed % (n - 1)), topology.clusters(D, labels)]
    for edges in made:
        is_tidy(n, edges)
        assert len(reached(n, pairs(edges))) == 1
    assert [len(edges) for edges in made[:4]] == [n * (n - 1) // 2, n - 1, n - 1, n - 1]


@given(D=distances())
@settings(max_examples=60, deadline=None)
def test_the_spanning_tree_is_as_short_as_kruskals(D):
    i, j = topology.spanning_tree(D).T
    assert D[i, j].sum() == pytest.approx(kruskal(D))


@given(D=distances(least=3), p=st.integers(1, 11))
@settings(max_examples=60, deadline=None)
def test_nearest_neighbours_are_those_of_either_side(D, p):
    n = len(D)
    p = min(p, n - 1)
    expected = set()
    for i in range(n):
        others = sorted((D[i, j], j) for j in range(n) if j != i)[:p]
        expected |= {tuple(sorted((i, j))) for _, j in others}
    edges = pairs(topology.nearest(D, p))
    if len(reached(n, expected)) > 1:
        assert expected < edges
        expected |= pairs(topology.spanning_tree(D))
    assert edges == expected


@given(D=distances(), scale=st.floats(1e-3, 1e3))
@settings(max_examples=20, deadline=None)
def test_units_do_not_matter(D, scale):
    D = np.round(D * 4) / 4  # so that rescaling neither makes nor breaks a tie
    scale = 2.0 ** round(np.log2(scale))
    assert pairs(topology.nearest(scale * D, 1)) == pairs(topology.nearest(D, 1))
    assert pairs(topology.spanning_tree(scale * D)) == pairs(topology.spanning_tree(D))


def test_two_far_groups_are_joined_with_a_warning(caplog):
    points = np.array([0, 1, 2, 100, 101, 102.0])
    D = np.abs(points[:, None] - points)
    with caplog.at_level(logging.WARNING):
        edges = topology.nearest(D, 1)
    assert (2, 3) in pairs(edges)
    assert "the 1 nearest neighbours leave 2 pieces; joined by the minimum spanning tree" in caplog.text


def test_duplicate_shapes_are_linked_at_distance_zero():
    D = np.zeros((4, 4))
    assert len(topology.spanning_tree(D)) == 3
    assert len(reached(4, pairs(topology.nearest(D, 1)))) == 1
    D[3] = D[:, 3] = [5, 5, 5, 0]
    assert len(pairs(topology.spanning_tree(D)) & {(0, 3), (1, 3), (2, 3)}) == 1


@given(D=distances(least=3), seed=st.integers(0, 99))
@settings(max_examples=40, deadline=None)
def test_clusters_are_trees_and_nearest_links(D, seed):
    n = len(D)
    labels = np.random.default_rng(seed).integers(0, 2, n)
    edges = pairs(topology.clusters(D, labels))
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
    D = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    expected = topology.clusters(D, [0, 0, 1, 1, 1])
    for labels in ("aabbb", ["cat", "cat", "dog", "dog", "dog"], iter([True, True, False, False, False])):
        np.testing.assert_array_equal(topology.clusters(D, labels), expected)


def test_shape_dna_distances_are_euclidean_and_free_of_size_where_areas_are_given():
    rng = np.random.default_rng(0)
    evals, areas = rng.random((5, 7)), rng.random(5)
    D = topology.shape_dna_distances(evals)
    assert D[1, 3] == pytest.approx(np.sqrt(((evals[1] - evals[3]) ** 2).sum()))
    scales = rng.random(5) + 0.5
    unit = topology.shape_dna_distances(evals, areas)
    np.testing.assert_allclose(
        topology.shape_dna_distances(evals / scales[:, None] ** 2, areas * scales**2), unit, atol=1e-12
    )


@given(n=st.integers(1, 9), edges=st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), max_size=9))
@settings(max_examples=50, deadline=None)
def test_components_are_those_found_by_walking(n, edges):
    edges = [(a % n, b % n) for a, b in edges]
    found = topology.components(n, edges)
    assert sorted(map(tuple, found)) == sorted(tuple(sorted(piece)) for piece in reached(n, edges))
    assert [len(piece) for piece in found] == sorted(map(len, found), reverse=True)


def test_borders():
    D = np.zeros((4, 4))
    for neighbours in (0, 4):
        with pytest.raises(InputError, match=f"neighbours={neighbours}: expected 1 to 3 for 4 shapes"):
            topology.nearest(D, neighbours)
    for centre in (-1, 4):
        with pytest.raises(InputError, match=f"centre={centre}: expected the number of a shape, 0 to 3"):
            topology.star(4, centre)
    with pytest.raises(InputError, match="labels: expected one for each of the 4 shapes, got 3"):
        topology.clusters(D, "aab")


def test_hubs_lie_in_the_midst_and_join_everything():
    places = np.array([0.0, 1, 2, 10, 11, 12, 100])
    distances = np.abs(places[:, None] - places)
    (one,) = (set(np.bincount(topology.hubs(distances, 1).ravel()).argsort()[-1:]),)
    assert one == {3}
    pairs = topology.hubs(distances, 2)
    assert len(pairs) == 6 + 6 - 1
    degrees = np.bincount(pairs.ravel())
    assert sorted(degrees)[-2:] == [6, 6]
    assert degrees[6] == 6  # the far one has no other near
    with pytest.raises(InputError, match="hubs=7: expected 1 to 6 for 7 shapes"):
        topology.hubs(distances, 7)
