import sys

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import lssd_learn
from lssd_learn.errors import InputError
from lssd_learn.nets import chamfer, nearest, nearest_squares
from lssd_learn.nets import chamfer as public
from lssd_learn.shapes import PointCloud

SEARCHES = ("tree", "pairs")


def chamfer_naive(a, b):
    """All differences of all pairs, two minima, two means."""
    squares = ((a[:, :, None] - b[:, None]) ** 2).sum(-1)
    return squares.amin(2).mean() + squares.amin(1).mean()


def clouds(*shape, seed=0):
    return torch.randn(*shape, 3, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize(("batch", "n", "m"), [(1, 1, 1), (3, 50, 50), (2, 7, 300), (4, 120, 1)])
def test_it_is_the_naive_distance_with_its_gradients(search, batch, n, m):
    results = []
    for distance in (lambda a, b: chamfer(a, b, search=search), chamfer_naive):
        a, b = clouds(batch, n).requires_grad_(), clouds(batch, m, seed=1).requires_grad_()
        value = distance(a, b)
        results.append([value, *torch.autograd.grad(value, [a, b])])
    for fast, naive in zip(*results, strict=True):
        torch.testing.assert_close(fast, naive, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("search", SEARCHES)
def test_gradcheck(search):
    a, b = clouds(2, 6).requires_grad_(), clouds(2, 9, seed=1).requires_grad_()
    assert torch.autograd.gradcheck(lambda a, b: chamfer(a, b, search=search), (a, b))
    assert torch.autograd.gradcheck(lambda a, b: nearest_squares(a, b, search=search), (a, b))


# On a coarse lattice, where points coincide and are equally near, as they never are at random.
lattice = st.integers(1, 12).flatmap(lambda n: arrays(np.float64, (n, 3), elements=st.integers(-3, 3)))


@settings(max_examples=80, deadline=None)
@given(a=lattice, b=lattice, order=st.randoms(use_true_random=False))
def test_laws(a, b, order):
    expected = chamfer_naive(torch.tensor(a)[None], torch.tensor(b)[None])
    for search in SEARCHES:
        value = chamfer(a, b, search=search)
        torch.testing.assert_close(value, expected)
        torch.testing.assert_close(chamfer(b, a, search=search), value)
        torch.testing.assert_close(chamfer(order.sample(list(a), len(a)), b, search=search), value)
        torch.testing.assert_close(chamfer(a + 5, b + 5, search=search), value)
        assert chamfer(a, a, search=search) == 0
        assert chamfer(a, np.vstack([a, b]), search=search) <= value


def test_nearest_is_nearest():
    queries, points = clouds(3, 40), clouds(3, 25, seed=1)
    expected = torch.cdist(queries, points).argmin(-1)
    for search in SEARCHES:
        assert torch.equal(nearest(queries, points, search=search), expected)
        assert torch.equal(nearest(queries[1], points[1], search=search), expected[1])
        squares = nearest_squares(queries, points, search=search)
        torch.testing.assert_close(squares, torch.cdist(queries, points).amin(-1) ** 2)
        torch.testing.assert_close(nearest_squares(queries[1], points[1], search=search), squares[1])


@pytest.mark.parametrize("search", SEARCHES)
def test_close_points_far_from_the_origin_keep_their_digits(search):
    """A thousand metres out and a millimetre apart: the product of matrices has no digit left there."""
    generator = torch.Generator().manual_seed(0)
    a = 1000 + torch.rand(1, 500, 3, generator=generator)
    b = a + 1e-3 * torch.randn(a.shape, generator=generator)
    expected = chamfer_naive(a.double(), b.double())
    torch.testing.assert_close(chamfer(a, b, search=search).double(), expected, rtol=1e-5, atol=0)


def test_chunks_change_nothing(monkeypatch):
    a, b = clouds(3, 31), clouds(3, 17, seed=1)
    expected = nearest(a, b, search="pairs")
    for pairs in (1, 3 * 17 * 4, 3 * 17 * 31):
        monkeypatch.setattr(sys.modules["lssd_learn.nets.chamfer"], "PAIRS", pairs)  # the name alone is the function
        assert torch.equal(nearest(a, b, search="pairs"), expected)


def test_threads_change_nothing():
    a, b = clouds(5, 64), clouds(5, 80, seed=1)
    assert chamfer(a, b, workers=3) == chamfer(a, b, workers=1)
    torch.set_num_threads(2)
    assert chamfer(a, b) == chamfer(a, b, workers=1)


def test_the_mean_goes_over_points_and_batch():
    a, b = clouds(4, 30), clouds(4, 50, seed=1)
    each = torch.stack([chamfer(x, y) for x, y in zip(a, b, strict=True)])
    torch.testing.assert_close(chamfer(a, b), each.mean())


def test_two_points():
    assert chamfer([[0.0, 0, 0]], [[0.0, 3, 4]]) == 50
    assert chamfer([[0.0, 0, 0]], [[0.0, 3, 4], [0, 0, 1]]) == 1 + (25 + 1) / 2


def test_arrays_integers_and_precisions():
    cloud = PointCloud([[0, 0, 0], [1, 2, 2]]).points  # read-only
    assert chamfer(cloud, cloud[:1]) == 4.5
    assert chamfer(cloud, cloud).dtype == torch.float64
    assert chamfer(cloud.astype(np.float32), cloud.astype(np.float32)).dtype == torch.float32
    assert chamfer(cloud.astype(int), cloud[:1].astype(int)) == 4.5
    assert chamfer(torch.tensor(cloud).half(), torch.tensor(cloud[:1]).half()).dtype == torch.float32


def test_the_gradient_of_a_step_points_downhill():
    a, b = clouds(2, 100).requires_grad_(), clouds(2, 100, seed=1)
    before = chamfer(a, b)
    (slope,) = torch.autograd.grad(before, a)
    assert chamfer(a - 10 * slope, b) < before


@pytest.mark.parametrize(
    ("a", "b", "message"),
    [
        (np.zeros((5, 2)), np.zeros((5, 3)), r"a: expected \(batch, points, 3\).*got \(5, 2\)"),
        (np.zeros((5, 3)), np.zeros(3), r"b: expected .*got \(3,\)"),
        (np.zeros((0, 3)), np.zeros((5, 3)), r"a: expected .*at least one point, got \(0, 3\)"),
        (np.zeros((0, 4, 3)), np.zeros((0, 5, 3)), r"a: expected .*got \(0, 4, 3\)"),
        (np.zeros((2, 4, 3)), np.zeros((3, 5, 3)), r"a, b: expected as many clouds"),
        (np.zeros((2, 4, 3)), np.zeros((5, 3)), r"a, b: expected as many clouds"),
        (np.zeros((5, 3)), np.array([[0, 0, np.nan], [np.inf, 0, 0]]), "b: expected finite points, 2 coordinates"),
    ],
)
def test_what_is_refused(a, b, message):
    for function in (chamfer, nearest, nearest_squares):
        pattern = message if function is chamfer else message.replace("a, b", "queries, points")
        pattern = pattern if function is chamfer else pattern.replace("a:", "queries:").replace("b:", "points:")
        with pytest.raises(InputError, match=pattern) as caught:
            function(a, b)
        assert "\n" not in str(caught.value)


def test_options_out_of_range():
    with pytest.raises(InputError, match="search: expected one of tree, pairs, got 'gpu'"):
        chamfer(clouds(2), clouds(2), search="gpu")
    with pytest.raises(InputError, match="workers=0"):
        chamfer(clouds(2), clouds(2), workers=0)


def test_it_is_public():
    assert lssd_learn.chamfer is public
