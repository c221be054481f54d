"""Paths between operators."""

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.operators import interpolate

METHODS = ["linear", "log_euclidean"]


def close(actual, expected):
    torch.testing.assert_close(actual, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
@given(m=st.integers(2, 6), t=st.floats(0, 1), null=st.booleans(), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_paths_begin_and_end_where_they_should_and_run_both_ways(positive, conformal, method, m, t, null, seed):
    D, E = (conformal if null else positive)(2, m, seed)
    start, middle, end = interpolate(D, E, [0, 0.5, 1], method)
    close(start, D)
    close(end, E)
    close(middle, interpolate(E, D, 0.5, method))
    close(interpolate(D, E, t, method), interpolate(E, D, 1 - t, method))
    close(interpolate(D, D, t, method), D)


@given(m=st.integers(2, 6), null=st.booleans(), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_the_log_euclidean_path_is_positive_definite_and_of_geometric_volume(positive, conformal, m, null, seed):
    """Even beyond its ends; log det is linear in t."""
    D, E = (conformal if null else positive)(2, m, seed)
    t = torch.linspace(-1, 2, 7, dtype=torch.float64)
    path = interpolate(D, E, t, "log_euclidean")
    close(path, path.mT)
    evals = torch.linalg.eigvalsh(path[:, int(null) :, int(null) :])
    assert (evals > 0).all()
    volumes = evals.log().sum(1)
    close(volumes, volumes[2] + t * (volumes[4] - volumes[2]))
    assert not null or float(path[:, 0].abs().max()) == 0


def test_the_linear_path_is_positive_definite_between_its_ends_only(positive):
    D, E = positive(2, 4)
    assert (torch.linalg.eigvalsh(interpolate(D, E, torch.linspace(0, 1, 5))) > 0).all()
    assert float(torch.linalg.eigvalsh(interpolate(D, E, 3)).min()) < 0


def test_the_midpoint_of_commuting_operators_is_the_geometric_mean():
    D, E = torch.diag(torch.tensor([1.0, 4.0])), torch.diag(torch.tensor([9.0, 1.0]))
    close(interpolate(D, E, 0.5, "log_euclidean"), torch.diag(torch.tensor([3.0, 2.0])).double())


def test_one_number_many_numbers_many_shapes(positive):
    D, E = positive(3, 4), positive(1, 4, 1)[0]
    for method in METHODS:
        assert interpolate(D, E, 0.3, method).shape == (3, 4, 4)
        many = interpolate(D.numpy(), E, torch.tensor([0.0, 0.3], dtype=torch.float64), method)
        assert many.shape == (2, 3, 4, 4)
        close(many[1], interpolate(D, E, 0.3, method))
        assert interpolate(D, E, [], method).shape == (0, 3, 4, 4)


def test_borders():
    eye = torch.eye(2)
    with pytest.raises(InputError, match="method='cubic': expected linear or log_euclidean"):
        interpolate(eye, eye, 0.5, "cubic")
    with pytest.raises(InputError, match=r"t: expected a finite number or several in a row, got \(1, 1\)"):
        interpolate(eye, eye, [[0.5]])
    with pytest.raises(InputError, match="t: expected a finite number"):
        interpolate(eye, eye, float("nan"))
