import pytest
import torch

from lssd_learn.nets.local import LEAST, most_likely


def normal(*shape, seed=0):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def most_likely_naive(guess, known, error, neighbours):
    """One guess after the other, by the formula for two normal distributions."""
    squares = ((known - guess) ** 2).sum(1)
    weights = (1 - squares / squares.sort().values[neighbours]).clamp(min=0)
    weights = weights / weights.sum()
    mean = weights @ known
    spread = (known - mean).T @ torch.diag(weights) @ (known - mean) + LEAST * error
    precision = torch.linalg.inv(spread) + torch.linalg.inv(error)
    return torch.linalg.inv(precision) @ (torch.linalg.inv(spread) @ mean + torch.linalg.inv(error) @ guess)


def test_it_is_the_formula():
    guesses, known, X = normal(7, 4), normal(50, 4, seed=1), normal(9, 4, seed=2)
    error = 0.1 * X.T @ X
    expected = torch.stack([most_likely_naive(guess, known, error, 20) for guess in guesses])
    torch.testing.assert_close(most_likely(guesses, known, error, 20), expected)


def test_errors_off_the_shapes_are_taken_off():
    """Shapes on two lines far apart in space; errors in all directions."""
    along, apart = normal(2, 200), torch.tensor([[1.0, 2, 3], [-30, 5, 5]], dtype=torch.float64)
    directions = torch.tensor([[1.0, 0, 0], [0, 0, 1]], dtype=torch.float64)
    lines = along[:, :, None] * directions[:, None] + apart[:, None]
    known, truth = lines[:, :100].flatten(0, 1), lines[:, 100:].flatten(0, 1)
    noise = 0.1 * normal(len(truth), 3, seed=1)
    better = most_likely(truth + noise, known, 0.01 * torch.eye(3, dtype=torch.float64), 50)
    assert ((better - truth) ** 2).mean() < 0.45 * (noise**2).mean()


def test_without_error_guesses_stay():
    guesses, known = normal(5, 3), normal(40, 3, seed=1)
    torch.testing.assert_close(most_likely(guesses, known, torch.zeros(3, 3, dtype=torch.float64), 20), guesses)


def test_moving_and_turning_everything_changes_nothing():
    guesses, known, error = normal(5, 3), normal(40, 3, seed=1), torch.diag(torch.tensor([0.1, 0.2, 0.3]).double())
    expected = most_likely(guesses, known, error, 20)
    torch.testing.assert_close(most_likely(guesses + 9, known + 9, error, 20), expected + 9)
    Q = torch.linalg.qr(normal(3, 3, seed=2))[0]
    torch.testing.assert_close(most_likely(guesses @ Q, known @ Q, Q.T @ error @ Q, 20), expected @ Q)


@pytest.mark.parametrize("n", [1, 3])
def test_fewer_shapes_than_neighbours(n):
    result = most_likely(normal(4, 5), normal(n, 5, seed=1), torch.eye(5, dtype=torch.float64), 30)
    assert result.isfinite().all()


def test_shapes_that_are_all_alike_are_what_is_likely():
    known = torch.ones(6, 2, dtype=torch.float64)
    result = most_likely(normal(3, 2), known, torch.eye(2, dtype=torch.float64), 4)
    torch.testing.assert_close(result, 1 + LEAST / (1 + LEAST) * (normal(3, 2) - 1))


def test_no_guesses():
    assert most_likely(normal(0, 3), normal(9, 3), torch.eye(3, dtype=torch.float64), 4).shape == (0, 3)


def test_known_vectors_at_one_distance_count_alike():
    """All as far as the first that does not count: without a floor none would count, and nothing would be likely."""
    known = torch.cat([torch.eye(3), -torch.eye(3)]).double()
    guess = torch.zeros(1, 3, dtype=torch.float64)
    result = most_likely(guess + 0.0, known + 2, torch.eye(3, dtype=torch.float64), 3)
    assert result.isfinite().all()
    centred = most_likely(guess + 2, known + 2, torch.eye(3, dtype=torch.float64), 3)
    torch.testing.assert_close(centred, guess + 2)
