"""ZoomOut keeps an exact map, and makes a small one as good."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.maps import euclidean_errors, from_correspondence, to_vertices, zoomout
from lssd_learn.maps.zoomout import zoomed_vertices


@pytest.mark.parametrize("size", [6, 20, 50])
def test_an_exact_map_stays(twins, size):
    exact = from_correspondence(twins.source, twins.target, twins.true)
    C = zoomout(twins.source, twins.target, exact[:size, :size])
    np.testing.assert_allclose(C, exact, atol=1e-9 if size > 6 else 0.2)
    C = zoomout(twins.source, twins.target, twins.true, 40, k=size)
    np.testing.assert_allclose(C, exact[:40, :40], atol=1e-9 if size > 6 else 0.2)


def test_the_identity_stays(twins):
    np.testing.assert_allclose(zoomout(twins.source, twins.source, np.eye(12)), np.eye(50), atol=1e-9)


def test_a_coarse_map_becomes_a_fine_one(twins):
    pair = twins.source, twins.target
    coarse = from_correspondence(*pair, twins.true)[:8, :8] + 0.02
    before, after = (
        euclidean_errors(twins.source_shape, zoomed_vertices(*pair, coarse, refined), twins.true).mean()
        for refined in (None, 50)
    )
    assert after < 0.7 * before


def test_sizes(twins):
    pair = twins.source, twins.target.truncate(30)
    assert zoomout(*pair, np.eye(8, 9)).shape == (30, 30)
    assert zoomout(*pair, np.eye(8, 9), 9, step=3).shape == (9, 9)
    assert zoomout(*pair, np.eye(20), 10).shape == (10, 10)
    np.testing.assert_array_equal(zoomed_vertices(*pair, np.eye(8), None), to_vertices(*pair, np.eye(8)))
    for wrong in ({"k_final": 31}, {"k_final": 0}, {"step": 0}, {"k": 0}):
        with pytest.raises(InputError, match="zoomout: expected 1 to 30 functions, step and k 1 or more, got"):
            zoomout(*pair, np.eye(8), **wrong)
