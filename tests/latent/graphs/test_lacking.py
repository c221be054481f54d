"""What is not reached on the others tells who lacks a part."""

import numpy as np

from lssd_learn.latent.graphs.lacking import lacking


def test_a_shape_lacks_what_most_of_the_others_have():
    edges = np.array([(0, 1), (0, 2), (1, 2), (2, 3), (0, 3)])
    whole, cut = (0.001, 0.002), (0.05, 0.005)  # shape 2 lacks a part; 3 is merely another
    unlike = (0.055, 0.05)
    assert lacking(4, edges, [whole, cut, cut, cut[::-1], unlike]) == [2]
    assert lacking(4, edges, [whole, None, cut, None, unlike]) == [2]
    assert lacking(4, edges, [None] * 5) == []
    assert lacking(4, edges, [whole, cut, whole, whole, whole]) == []  # one map of three says so


def test_beside_one_that_lacks_much_those_that_lack_little_are_found():
    """Shapes 0 and 1 are what all are mapped to; 0 lacks a third, 2 and 3 a tenth, 4 to 6 nothing."""
    edges = np.array([(i, j) for i in (0, 1) for j in range(i + 1, 7)])
    size = np.array([0.67, 1.0, 0.9, 0.9, 1.0, 1.0, 1.0])
    shares = [(max(0.0, size[i] - size[j]), max(0.0, size[j] - size[i])) for i, j in edges]
    assert lacking(7, edges, shares) == [0, 2, 3]
