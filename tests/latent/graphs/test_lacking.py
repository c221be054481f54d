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
