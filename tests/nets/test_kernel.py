import pytest
import torch

from lssd_learn.nets.kernel import gaussian, slopes


@pytest.fixture
def operators():
    X = torch.randn(5, 4, 7, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    return X @ X.mT


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
