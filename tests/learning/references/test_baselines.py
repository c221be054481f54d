from dataclasses import astuple

import numpy as np
import pytest
import torch

from lssd_learn.learning import operator_features, ridge_reference, split
from lssd_learn.learning.references.baselines import (
    base_scores,
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


def test_inner_products_do_as_well_as_features(noisy):
    operators, targets = noisy
    features = operator_features(operators)
    same(wide_baseline(features, targets, PARTS), ridge_reference(features, targets, PARTS))


def test_a_spectrum_is_read_plain_or_in_logarithms():
    generator = np.random.default_rng(0)
    evals = np.hstack([np.zeros((60, 1)), np.cumsum(generator.random((60, 8)) + 0.1, axis=1)])
    assert spectrum_baseline(evals, evals[:, 1:4], PARTS).mse < 1e-12
    assert spectrum_baseline(evals, np.log(evals[:, 1:4]), PARTS).mse < 1e-12
    targets = generator.random((60, 2))
    assert spectrum_baseline(evals + 1e9 * (np.arange(9) == 0), targets, PARTS) == spectrum_baseline(
        evals, targets, PARTS
    )


def test_base_shapes_are_scored_as_their_operators_are(noisy):
    operators, targets = noisy
    area, conformal = torch.as_tensor(operators[:, 0]), torch.as_tensor(operators[::-1, 0].copy())
    wide = [torch.block_diag(*[torch.ones(10, 10)] * 2).double() * d.repeat(1, 2, 2) for d in (area, conformal)]
    scores = base_scores([(4, wide), (2, wide[::-1])], targets, PARTS, {"area": [0], "operators": [0, 1]})
    assert [entry.base for entry in scores] == [4, 2]
    both = operator_features(torch.stack(wide, 1))
    for entry, own in zip(scores, wide, strict=True):
        same(entry.by_kind["area"], ridge_reference(operator_features(own[:, None]), targets, PARTS))
        same(entry.by_kind["operators"], ridge_reference(both, targets, PARTS))
