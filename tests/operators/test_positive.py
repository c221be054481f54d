import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.operators import analogy, logarithm
from lssd_learn.operators.positive import positive_part


def positive(n, m=6, seed=0, size=0.05):
    X = torch.randn(n, m, m, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return torch.matrix_exp(size * (X + X.mT))


def test_operators_stay_what_they_are():
    D = positive(5)
    torch.testing.assert_close(positive_part(D), D)


def test_everything_gets_a_logarithm():
    A, B, C = positive(3)
    product = analogy(A, B, C)
    made = positive_part(product)
    torch.testing.assert_close(made, (product + product.T) / 2)
    assert logarithm(made).isfinite().all()
    evals = torch.linalg.eigvalsh(positive_part(C + B - 5 * A, floor=0.1))
    assert evals[0] >= 0.0999 * evals[-1] > 0


def test_null_functions_stay_null():
    D = positive(2)
    D[:, 0] = D[:, :, 0] = 0
    torch.testing.assert_close(positive_part(D), D)


def test_errors():
    with pytest.raises(InputError, match="X: expected operators"):
        positive_part(torch.zeros(3, 4))
