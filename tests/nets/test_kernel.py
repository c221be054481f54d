import pytest
import scipy.linalg
import torch

from lssd_learn.errors import InputError
from lssd_learn.nets.kernel import gaussian, log_vectors, slopes


@pytest.fixture
def operators():
    X = torch.randn(5, 4, 7, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    return X @ X.mT


def test_logarithms_are_scipys_and_keep_inner_products(operators):
    logs = torch.stack([torch.from_numpy(scipy.linalg.logm(D.numpy())) for D in operators])
    vectors = log_vectors(operators)
    assert vectors.shape == (5, 10)
    assert torch.allclose(vectors @ vectors.T, torch.einsum("aij,bij->ab", logs, logs))


def test_logarithms_do_not_amplify_rounding(operators):
    evals, V = torch.linalg.eigh(operators[0])
    evals[0] = -1e-8 * evals[-1]  # what float32 may make of zero
    assert log_vectors((V * evals @ V.T)[None]).norm() < 50


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ([[1.0, 2.0], [0.0, 1.0]], "symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "positive"),
        ([[0.0]], "positive"),
    ],
)
def test_what_has_no_logarithm_is_refused(matrix, message):
    with pytest.raises(InputError, match=message):
        log_vectors(torch.tensor([matrix]))


def test_gaussian_and_slopes_are_those_of_the_formula(operators):
    generator = torch.Generator().manual_seed(1)
    x, centres = (torch.randn(n, 4, generator=generator, dtype=torch.float64) for n in (3, 6))
    weights, metric = torch.randn(6, generator=generator, dtype=torch.float64), operators[0]

    def naive(x):
        away = x[:, None] - centres
        return torch.exp(-0.5 * torch.einsum("abi,ij,abj->ab", away, metric, away))

    assert torch.allclose(gaussian(x, centres, metric), naive(x))
    at = centres.clone().requires_grad_()
    (expected,) = torch.autograd.grad((naive(at) @ weights).sum(), at)
    assert torch.allclose(slopes(gaussian(centres, centres, metric), centres, weights, metric), expected)
