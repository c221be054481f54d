"""Edges that are not to be trusted are left out, but for those that hold the network together."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.latent.graphs.trusted import trusted


@st.composite
def networks(draw):
    n = draw(st.integers(2, 9))
    graph = nx.gnp_random_graph(n, draw(st.floats(0, 1)), seed=draw(st.integers(0, 1000)))
    graph.add_edges_from((draw(st.integers(0, i - 1)), i) for i in range(1, n))
    edges = np.array(sorted(tuple(sorted(edge)) for edge in graph.edges))
    qualities = draw(st.lists(st.integers(0, 100), min_size=len(edges), max_size=len(edges)))
    return n, edges, np.array(qualities) / 100


@given(networks())
def test_what_stays_is_connected_and_as_good_as_can_be(case):
    n, edges, qualities = case
    kept, bridges = trusted(n, edges, qualities, 0.5)
    graph = nx.Graph(edges[kept].tolist())
    assert set(graph.nodes) == set(range(n))
    assert nx.is_connected(graph)
    np.testing.assert_array_equal(np.sort(bridges), np.flatnonzero(kept & (qualities < 0.5)))
    assert kept[qualities >= 0.5].all()
    good = nx.Graph()
    good.add_nodes_from(range(n))
    good.add_edges_from(edges[qualities >= 0.5].tolist())
    assert len(bridges) == nx.number_connected_components(good) - 1  # no more than needed
    assert (np.diff(qualities[bridges]) >= 0).all()


def test_the_better_of_two_bad_maps_is_the_bridge_and_unknown_ones_are_trusted():
    edges = np.array([[0, 1], [0, 2], [1, 2]])
    kept, bridges = trusted(3, edges, np.array([np.nan, 0.1, 0.3]), 0.5)
    assert kept.tolist() == [True, False, True]
    assert bridges.tolist() == [2]


@pytest.mark.parametrize("level", [0.0, 0.05])
def test_nothing_is_left_out_where_all_is_good_enough(level):
    edges = np.array([[0, 1], [0, 2], [1, 2]])
    kept, bridges = trusted(3, edges, np.array([0.9, 0.1, 0.3]), level)
    assert kept.all()
    assert not len(bridges)
