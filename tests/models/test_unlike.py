"""How unlike the training shapes a shape is: told by how far these lie from one another."""

import logging

import numpy as np
import pytest
import torch

from lssd_learn.models import unlike as module
from lssd_learn.models.unlike import radii, tell_of_unlike, unlike


def drawn(n, seed, size=4):
    X = torch.randn(n, 2, size, size, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return torch.eye(size) + 0.1 * (X + X.mT)


def test_shapes_of_the_same_kind_lie_as_near_as_the_known_ones():
    share, ratio = unlike(drawn(400, 1), drawn(300, 0))
    assert share.mean() == pytest.approx(0.5, abs=0.06)
    assert np.quantile(share, [0.1, 0.9]) == pytest.approx([0.1, 0.9], abs=0.07)
    assert (ratio > 1).mean() < 0.02


def test_shapes_of_another_kind_lie_outside():
    known = drawn(300, 0)
    for other in (3 * drawn(20, 1), drawn(20, 1) + torch.diag(torch.tensor([1.0, 0, 0, -1]))):
        share, ratio = unlike(other, known)
        assert (share == 1).all()
        assert (ratio > 1).all()


def test_a_known_shape_is_as_near_as_can_be():
    known = drawn(50, 0)
    share, ratio = unlike(known[:5], known)
    assert (share == 0).all()
    assert (ratio == 0).all()


def test_channels_count_alike_whatever_their_scale():
    new, known = drawn(30, 1), drawn(60, 0)
    scale = torch.tensor([1.0, 1e4])[:, None, None]
    for one, two in zip(unlike(new, known), unlike(scale * new, scale * known), strict=True):
        np.testing.assert_allclose(one, two)


def test_of_many_known_shapes_some_are_compared(monkeypatch):
    monkeypatch.setattr(module, "COMPARED", 100)
    new, known = drawn(200, 1), drawn(1000, 0)
    share, _ = unlike(new, known)
    assert share.mean() == pytest.approx(0.5, abs=0.12)
    np.testing.assert_array_equal(share, unlike(new, known)[0])


def test_those_outside_are_named(caplog):
    with caplog.at_level(logging.WARNING):
        tell_of_unlike(np.array([0.4, 1.1]), ["a", "b"])
        assert not caplog.messages
        tell_of_unlike(np.array([0.4, 1.1, 2.5]), ["a", "b", "c"])
    (line,) = caplog.messages
    assert line.startswith("1 of 3 shapes (c) are unlike anything the model has seen, up to 2.5 times")


def test_radii_do_not_depend_on_where_a_cloud_lies():
    cloud = torch.randn(3, 200, 3, generator=torch.Generator().manual_seed(0))
    np.testing.assert_allclose(radii(10 * cloud + 100), 10 * radii(cloud), rtol=1e-4)
