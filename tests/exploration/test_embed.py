"""Principal components of operators against plain numpy."""

import numpy as np
import pytest
import torch
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration import embed, pca


def operators(n, m, seed=0):
    D = np.random.default_rng(seed).normal(size=(n, m, m))
    return torch.from_numpy(np.eye(m) + 0.1 * (D + D.swapaxes(1, 2)))


def covariance(D, dimensions):
    """Coordinates and ratios from the eigenvectors of the covariance matrix."""
    flat = D.numpy().reshape(len(D), -1)
    values, vectors = np.linalg.eigh(np.cov(flat.T))
    order = np.argsort(values)[::-1][:dimensions]
    return (flat - flat.mean(0)) @ vectors[:, order], values[order] / values.sum()


@given(n=st.integers(4, 12), m=st.integers(2, 4), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_it_is_the_eigenbasis_of_the_covariance(n, m, seed):
    D = operators(n, m, seed)
    dimensions = min(3, n - 1)
    found = pca(D, dimensions)
    points, ratios = covariance(D, dimensions)
    assume((-np.diff(covariance(D, n - 1)[1]) > 1e-4).all())  # axes of equal variance are any
    assert found.points.shape == (n, dimensions)
    np.testing.assert_allclose(np.abs(found.points.numpy()), np.abs(points), atol=1e-6)
    np.testing.assert_allclose(found.ratios.numpy(), ratios, atol=1e-10)


def test_all_dimensions_keep_all_distances():
    D = operators(7, 5)
    found = pca(D, 6)
    expected = torch.cdist(D.flatten(1), D.flatten(1))
    torch.testing.assert_close(torch.cdist(found.points, found.points), expected, rtol=0, atol=1e-10)
    assert float(found.ratios.sum()) == pytest.approx(1)


def test_the_points_are_centred_uncorrelated_and_ordered():
    found = pca(operators(9, 4), 4)
    torch.testing.assert_close(found.points.sum(0), torch.zeros(4).double(), rtol=0, atol=1e-12)
    gram = found.points.T @ found.points
    torch.testing.assert_close(gram, torch.diag(gram.diagonal()), rtol=0, atol=1e-12)
    assert (found.ratios.diff() <= 0).all()


def test_each_axis_points_to_its_farthest_shape():
    found = pca(operators(9, 4), 3)
    assert torch.equal(found.points.max(0).values, found.points.abs().max(0).values)


def test_neither_a_shift_nor_the_order_of_the_shapes_changes_the_picture():
    D, order = operators(9, 4), torch.randperm(9, generator=torch.Generator().manual_seed(0))
    points = pca(D, 2).points
    torch.testing.assert_close(pca(D + 3, 2).points, points, rtol=0, atol=1e-10)
    torch.testing.assert_close(pca(D[order], 2).points, points[order], rtol=0, atol=1e-10)


def test_channels_arrays_and_single_precision_are_taken():
    D = operators(6, 3)
    both = torch.stack([D, 2 * D], dim=1)
    torch.testing.assert_close(pca(both, 2).points, 5**0.5 * pca(D, 2).points, rtol=0, atol=1e-10)
    torch.testing.assert_close(pca(D.numpy(), 2).points, pca(D, 2).points)
    assert pca(D.float(), 2).points.dtype == torch.float64


def test_equal_shapes_are_one_point():
    found = pca(torch.eye(3).expand(5, 3, 3), 2)
    torch.testing.assert_close(found.points, torch.zeros(5, 2).double(), rtol=0, atol=1e-12)
    assert found.ratios.isfinite().all()


def test_no_dimension_is_refused():
    with pytest.raises(InputError, match="dimensions=0: expected a whole number, 1 or more"):
        pca(operators(6, 3), 0)


@pytest.mark.parametrize(("n", "m"), [(2, 3), (5, 1), (1, 3)])
def test_axes_beyond_those_there_are_are_zero(n, m):
    found = pca(operators(n, m), 3)
    assert found.points.shape == (n, 3)
    torch.testing.assert_close(found.points[:, 1:], torch.zeros(n, 2).double(), rtol=0, atol=1e-12)
    assert found.ratios.isfinite().all()


def test_embed_shows_operators_or_what_they_do_to_functions():
    D = operators(6, 4)
    torch.testing.assert_close(embed(D).points, pca(D).points)
    alpha = np.eye(4)[:, :2]
    torch.testing.assert_close(embed(D, 3, alpha).points, pca(D[:, :, :2], 3).points)
    torch.testing.assert_close(embed(D.numpy(), alpha=alpha[:, 0]).points, pca(D[:, :, 0]).points)


@pytest.mark.parametrize("alpha", [None, torch.arange(4.0).double(), torch.eye(4).double()[:, :2]])
def test_further_shapes_find_their_places(alpha):
    D = operators(9, 4)
    found = embed(D, 3, alpha)
    torch.testing.assert_close(found.transform(D), found.points, rtol=0, atol=1e-12)
    mean = found.transform(D.mean(0, keepdim=True))
    torch.testing.assert_close(mean, torch.zeros(1, 3).double(), rtol=0, atol=1e-12)
    new = operators(3, 4, seed=1)
    if alpha is None:  # of all dimensions there are, only what lies off them is lost
        whole = embed(D, 8)
        rest = (new - D.mean(0)).flatten(1) - whole.transform(new) @ whole.axes
        assert (whole.axes @ rest.T).abs().max() < 1e-12
        with pytest.raises(InputError, match=r"operators: expected as many entries as those embedded, got \(3, 5, 5\)"):
            found.transform(operators(3, 5))


def test_an_axis_without_variance_gives_further_shapes_nothing():
    two = operators(2, 4)
    assert not embed(two, 3).transform(operators(3, 4, seed=1))[:, 1:].any()
