from dataclasses import astuple

import numpy as np
import pytest
import torch

from lssd_learn.learning import Split, mean_reference, operator_features, ridge_reference, split
from lssd_learn.learning.references.baselines import (
    base_scores,
    feature_baseline,
    log_features,
    spectrum_baseline,
    wide_baseline,
)

PARTS = split(60, 0)


def same(baseline, reference):
    assert astuple(baseline)[:3] == pytest.approx(astuple(reference)[:3], rel=1e-6)


@pytest.fixture
def noisy(collection):
    """Operators (60, 1, 10, 10) and 3 parameters that do not follow from them alone."""
    operators, parameters = collection
    return operators, parameters + 0.1 * np.random.default_rng(1).normal(size=parameters.shape)


def test_a_baseline_is_the_ridge_reference(noisy):
    operators, targets = noisy
    features = operator_features(operators)
    same(feature_baseline(features, targets, PARTS), ridge_reference(features, targets, PARTS))
    same(wide_baseline(features, targets, PARTS), ridge_reference(features, targets, PARTS))


def test_its_validation_error_is_what_it_was_chosen_by(noisy):
    operators, targets = noisy
    features = operator_features(operators)
    baseline = feature_baseline(features, targets, PARTS)
    swapped = Split(train=PARTS.train, test=PARTS.validation, validation=PARTS.validation)
    assert baseline.validation == pytest.approx(ridge_reference(features, targets, swapped).mse)


def test_constant_features_are_the_mean_of_the_targets(noisy):
    _, targets = noisy
    baseline, mean = feature_baseline(np.ones((60, 1)), targets, PARTS), mean_reference(targets, PARTS)
    assert (baseline.mse, baseline.l1) == (mean.mse, mean.l1)


def test_a_spectrum_is_read_plain_or_in_logarithms():
    generator = np.random.default_rng(0)
    evals = np.hstack([np.zeros((60, 1)), np.cumsum(generator.random((60, 8)) + 0.1, axis=1)])
    assert spectrum_baseline(evals, evals[:, 1:4], PARTS).mse < 1e-12
    assert spectrum_baseline(evals, np.log(evals[:, 1:4]), PARTS).mse < 1e-12
    targets = generator.random((60, 2))
    assert spectrum_baseline(evals + 1e9 * (np.arange(9) == 0), targets, PARTS) == spectrum_baseline(
        evals, targets, PARTS
    )


def test_logarithms_leave_null_functions_out_and_ignore_the_gauge(collection):
    area = torch.as_tensor(collection[0])
    padded = torch.zeros(60, 1, 11, 11).to(area)
    padded[:, :, 1:, 1:] = area
    features = log_features(torch.cat([padded, padded], 1), PARTS.train)
    assert features.shape == (60, 2 * 55)
    Q = torch.linalg.qr(torch.randn(10, 10, generator=torch.Generator().manual_seed(0)).double())[0]
    plain, turned = (log_features(operators, PARTS.train) for operators in (area, Q.T @ area @ Q))
    np.testing.assert_allclose(features @ features.T, 2 * plain @ plain.T, atol=1e-8)
    np.testing.assert_allclose(turned @ turned.T, plain @ plain.T, atol=1e-8)


def test_base_shapes_are_scored_as_their_operators_are(noisy):
    operators, targets = noisy
    area, conformal = torch.as_tensor(operators[:, 0]), torch.as_tensor(operators[::-1, 0].copy())
    wide = [torch.block_diag(*[torch.ones(10, 10)] * 2).double() * d.repeat(1, 2, 2) for d in (area, conformal)]
    scores = base_scores([(4, wide), (2, wide[::-1])], targets, PARTS)
    assert [entry.base for entry in scores] == [4, 2]
    both = operator_features(torch.stack(wide, 1))
    for entry, own in zip(scores, wide, strict=True):
        same(entry.by_kind["area"], ridge_reference(operator_features(own[:, None]), targets, PARTS))
        same(entry.by_kind["operators"], ridge_reference(both, targets, PARTS))
