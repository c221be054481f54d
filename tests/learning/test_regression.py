"""Parameters in any unit: learnt in one scale, told in their own."""

import numpy as np
import pytest
import torch

from lssd_learn.learning import Regression, ShapeData, fit, load, mean_reference, predict, ridge_reference, split
from lssd_learn.nets import MLP, KernelMachine

N, SIZE = 80, 5
UNITS = {"years": (50.0, 1950.0), "thousandths": (1e-3, 0.0), "far": (1.0, 6e6), "below zero": (1e4, -2e4)}


@pytest.fixture(scope="module")
def shapes():
    """Symmetric matrices near the identity, and two numbers in [0, 1] that follow from them."""
    generator = torch.Generator().manual_seed(0)
    X = 0.2 * torch.randn(N, 1, SIZE, SIZE, generator=generator, dtype=torch.float64)
    logs = (X + X.mT) / 2
    numbers = torch.stack([logs[:, 0, 0, 1], logs[:, 0, 2, 2]], dim=1)
    return torch.linalg.matrix_exp(logs), ((numbers - numbers.amin(0)) / (numbers.amax(0) - numbers.amin(0))).numpy()


def trained(operators, targets, out, net=MLP, **options):
    data = ShapeData(operators, targets, split=split(N, 0), seed=0, batch=20, **options)
    return fit(net, data, epochs=30, learning_rate=0.01, seed=0, out=out), data


@pytest.mark.parametrize("net", [MLP, KernelMachine])
@pytest.mark.parametrize("unit", UNITS)
def test_the_unit_does_not_matter(shapes, tmp_path, net, unit):
    operators, targets = shapes
    factor, shift = UNITS[unit]
    plain, _ = trained(operators, targets, tmp_path / "plain", net)
    other, data = trained(operators, factor * targets + shift, tmp_path / "other", net)
    assert plain["test/relative_mse"] < 0.5
    assert other["test/relative_mse"] == pytest.approx(plain["test/relative_mse"], rel=0.02)
    assert other["test/mse"] == pytest.approx(factor**2 * plain["test/mse"], rel=0.02)
    assert other["test/l1"] == pytest.approx(abs(factor) * plain["test/l1"], rel=0.02)
    reader = load(tmp_path / "other" / "best.ckpt", net)
    found = predict(reader, data.inputs) - data.targets.numpy()
    assert np.mean(found[data.split.test] ** 2) == pytest.approx(other["test/mse"], rel=1e-4)


def test_parameters_in_several_units_count_alike(shapes, tmp_path):
    """Without one scale the one in large numbers is all that is learnt."""
    operators, targets = shapes
    mixed = targets * [1e-3, 1e3]
    plain, _ = trained(operators, targets, tmp_path / "plain")
    metrics, _ = trained(operators, mixed, tmp_path / "mixed")
    assert metrics["test/relative_mse"] == pytest.approx(plain["test/relative_mse"], rel=0.02)
    parts = split(N, 0)
    for made in (mean_reference, lambda *arguments: ridge_reference(operators.flatten(1), *arguments)):
        one, two = made(targets, parts), made(mixed, parts)
        np.testing.assert_allclose(two.errors, one.errors * [1e-3, 1e3], rtol=1e-6, atol=1e-12)


def test_raw_parameters_are_seen_as_they_are(shapes, tmp_path):
    operators, targets = shapes
    _, data = trained(operators, targets, tmp_path, standardise_targets=False)
    reader = load(tmp_path / "best.ckpt", MLP)
    assert reader.minimised == "mse"
    inputs = data.inputs[:3]
    assert torch.equal(reader(inputs), reader.net(inputs - reader.mean))


def test_what_the_net_sees_is_as_uniform_numbers_are(shapes):
    _, targets = shapes
    learner = Regression(torch.nn.Identity(), 0.01)
    learner.adapt_to(torch.tensor(1e4 * targets - 3))
    seen = learner.aims(torch.tensor(1e4 * targets - 3))
    torch.testing.assert_close(seen.mean(0), torch.full((2,), 0.5, dtype=torch.float64))
    torch.testing.assert_close(seen.std(0, correction=0), torch.full((2,), 12**-0.5, dtype=torch.float64))
    torch.testing.assert_close(learner.told(seen), torch.tensor(1e4 * targets - 3))


def test_a_constant_parameter_is_no_division_by_zero(shapes, tmp_path):
    operators, targets = shapes
    metrics, _ = trained(operators, np.column_stack([targets, np.full(N, 7.0)]), tmp_path)
    assert np.isfinite(metrics["test/relative_mse"])


def test_checkpoints_from_before_are_read(shapes, tmp_path):
    operators, targets = shapes
    _, data = trained(operators, targets, tmp_path, standardise_targets=False)
    file = torch.load(tmp_path / "best.ckpt", weights_only=True)
    expected = load(tmp_path / "best.ckpt", MLP)(data.inputs)
    for name in ("centre", "scale", "deviation"):
        del file["state_dict"][name]
    torch.save(file, tmp_path / "old.ckpt")
    assert torch.equal(load(tmp_path / "old.ckpt", MLP)(data.inputs), expected)
