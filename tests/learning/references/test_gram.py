import numpy as np
import pytest

from lssd_learn.learning import split
from lssd_learn.learning.references import gram as module
from lssd_learn.learning.references.gram import gram, ridge_of_gram
from lssd_learn.learning.references.ridge import ALPHAS, Ridge

PARTS = split(60, 0)


@pytest.fixture
def problem():
    """Features far more numerous than shapes, far from zero: (features, targets)."""
    generator = np.random.default_rng(0)
    features = generator.normal(size=(60, 500)) * np.geomspace(1, 1e-4, 500) + 7
    return features, features[:, :3] + 0.1 * generator.normal(size=(60, 3))


def test_products_are_those_of_centred_features_whatever_the_blocks(problem, monkeypatch):
    features, _ = problem
    centred = features - features[PARTS.train].mean(0)
    for block in (4096, 7):
        monkeypatch.setattr(module, "BLOCK", block)
        np.testing.assert_allclose(gram(features, PARTS.train), centred @ centred.T, atol=1e-10)


def test_products_of_float32_features_are_summed_in_float64(problem):
    features = problem[0].astype(np.float32)
    np.testing.assert_array_equal(gram(features, PARTS.train), gram(features.astype(float), PARTS.train))


def test_products_of_features_side_by_side_add_up(problem):
    features, _ = problem
    parts = [gram(half, PARTS.train) for half in (features[:, :200], features[:, 200:])]
    np.testing.assert_allclose(sum(parts), gram(features, PARTS.train), atol=1e-10)


def test_the_ridge_of_products_is_that_of_the_features(problem):
    features, targets = problem
    ridge = ridge_of_gram(gram(features, PARTS.train), targets, PARTS.train)
    oracle = Ridge.fit(features, targets, PARTS.train)
    for alpha in ALPHAS:
        for positions in PARTS.items():
            found, wanted = (r.at(positions[1], alpha) for r in (ridge, oracle))
            np.testing.assert_allclose(found, wanted, atol=1e-6)


def test_features_that_are_all_the_same_predict_the_mean(problem):
    _, targets = problem
    ridge = ridge_of_gram(gram(np.ones((60, 4)), PARTS.train), targets, PARTS.train)
    assert ridge.is_constant
    np.testing.assert_array_equal(ridge.at(PARTS.test, 1.0), np.tile(targets[PARTS.train].mean(0), (9, 1)))
