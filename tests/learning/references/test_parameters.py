from dataclasses import replace

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.learning import mean_reference, operator_features, ridge_reference, split
from lssd_learn.learning.references import ridge as ridge_module
from lssd_learn.learning.references.ridge import ALPHAS, Ridge


@pytest.fixture
def problem():
    """More features than samples, and noise: (features, targets, split)."""
    generator = np.random.default_rng(0)
    features = generator.normal(size=(80, 120)) + 3
    targets = features @ generator.normal(size=(120, 4)) / 10 + 0.1 * generator.normal(size=(80, 4))
    return features, targets, split(80, 0)


def test_mean_is_the_variance_around_the_training_mean(problem):
    _, targets, parts = problem
    train, test = targets[parts.train], targets[parts.test]
    expected = np.mean(test.var(0) + (test.mean(0) - train.mean(0)) ** 2)
    assert mean_reference(targets, parts).mse == pytest.approx(expected, rel=1e-12)


def test_mean_of_the_papers_parameters():
    targets = np.random.default_rng(0).random((40_000, 12))
    reference = mean_reference(targets, split(40_000, 0))
    assert reference.mse == pytest.approx(1 / 12, rel=0.01)
    assert reference.l1 == pytest.approx(0.25, rel=0.01)


@pytest.mark.parametrize("wide", [True, False])
def test_ridge_is_that_of_the_normal_equations(problem, wide):
    features, targets, parts = problem
    features = features if wide else features[:, :7]
    reference = ridge_reference(features, targets, parts)
    centre, mean = features[parts.train].mean(0), targets[parts.train].mean(0)
    X = features[parts.train] - centre
    rank = min(X.shape)
    alpha = reference.alpha * np.trace(X.T @ X) / rank
    B = np.linalg.solve(X.T @ X + alpha * np.eye(X.shape[1]), X.T @ (targets[parts.train] - mean))
    error = (features[parts.test] - centre) @ B + mean - targets[parts.test]
    assert reference.mse == pytest.approx(np.mean(error**2), rel=1e-8)
    assert reference.l1 == pytest.approx(np.abs(error).mean(), rel=1e-8)


def test_of_many_shapes_ridge_comes_from_products_and_is_the_same(problem, monkeypatch):
    features, targets, parts = problem
    features = np.column_stack([features[:, :7], np.ones(80)])  # and one that tells nothing
    expected, first = ridge_reference(features, targets, parts), Ridge.fit(features, targets, parts.train)
    monkeypatch.setattr(ridge_module, "MANY", 11)
    found, second = ridge_reference(features, targets, parts), Ridge.fit(features, targets, parts.train)
    assert second.singular[-1] == 0
    assert found.mse == pytest.approx(expected.mse, rel=1e-8)
    for alpha in (1e-6, 1e-2, 1.0):
        np.testing.assert_allclose(second.at(parts.test, alpha), first.at(parts.test, alpha), rtol=1e-8)
        np.testing.assert_allclose(second.predict(features[:3], alpha), second.at(np.arange(3), alpha), rtol=1e-8)
    constant = Ridge.fit(np.ones((80, 3)), targets, parts.train)
    assert constant.is_constant


def test_ridge_chooses_on_validation(problem):
    features, targets, parts = problem
    alphas = np.logspace(-6, 3, 10)
    chosen = ridge_reference(features, targets, parts, alphas).alpha
    scores = []
    for alpha in alphas:
        swapped = type(parts)(train=parts.train, test=parts.validation, validation=parts.validation)
        scores.append(ridge_reference(features, targets, swapped, [alpha]).mse)
    assert chosen == alphas[np.argmin(scores)]


def test_ridge_does_not_look_at_the_test_split(problem):
    features, targets, parts = problem
    other = targets.copy()
    other[parts.test] += 100
    assert ridge_reference(features, targets, parts).alpha == ridge_reference(features, other, parts).alpha


def test_ridge_is_exact_on_linear_data(collection):
    operators, parameters = collection
    reference = ridge_reference(operator_features(operators), parameters, split(60, 0))
    assert reference.mse < 1e-15


def test_ridge_has_no_scale(problem):
    features, targets, parts = problem
    small, large = (ridge_reference(c * features, targets, parts) for c in (1e-3, 1e4))
    assert small.alpha == large.alpha
    assert small.mse == pytest.approx(large.mse, rel=1e-9)


def test_constant_features_predict_the_mean(problem):
    _, targets, parts = problem
    assert ridge_reference(np.ones((80, 3)), targets, parts) == mean_reference(targets, parts)


@pytest.mark.parametrize("symmetric", [True, False])
def test_features_keep_the_inner_products(symmetric):
    operators = np.random.default_rng(0).normal(size=(6, 2, 5, 5))
    if symmetric:
        operators = operators + operators.swapaxes(2, 3)
    features = operator_features(operators)
    assert features.shape == (6, 2 * 15 if symmetric else 2 * 25)
    flat = operators.reshape(6, -1)
    np.testing.assert_allclose(features @ features.T, flat @ flat.T, atol=1e-10)


def test_errors(problem):
    features, targets, parts = problem
    with pytest.raises(InputError, match=r"features must be \(80, d\), got \(79, 120\)"):
        ridge_reference(features[1:], targets, parts)
    with pytest.raises(InputError, match=r"targets must be \(n, p\), got \(80,\)"):
        mean_reference(targets[:, 0], parts)
    with pytest.raises(InputError, match=r"operators must be \(n, channels, m, m\), got \(3, 4, 4\)"):
        operator_features(np.zeros((3, 4, 4)))


def test_the_validation_error_is_what_the_strength_was_chosen_by(collection):
    operators, parameters = collection
    features, parts = operator_features(operators), split(60, 0)
    targets = parameters + 0.1 * np.random.default_rng(1).normal(size=parameters.shape)
    swapped = replace(parts, test=parts.validation)
    found = ridge_reference(features, targets, parts)
    assert found.validation == pytest.approx(ridge_reference(features, targets, swapped).mse)
    ridge = Ridge.fit(features, targets, parts.train)
    errors = [np.mean((ridge.at(parts.validation, a) - targets[parts.validation]) ** 2) for a in ALPHAS]
    assert found.validation == pytest.approx(min(errors))


def test_a_ridge_reads_further_shapes():
    rng = np.random.default_rng(0)
    X, T = rng.normal(size=(12, 30)), rng.normal(size=(12, 2))
    train, rest = np.arange(8), np.arange(8, 12)
    ridge = Ridge.fit(X, T, train)
    np.testing.assert_allclose(ridge.predict(X[rest], 0.1), ridge.at(rest, 0.1), atol=1e-12)
    np.testing.assert_allclose(ridge.predict(X[:1], 1e-12), T[:1], atol=1e-6)
    with pytest.raises(InputError, match=r"features must be \(m, 30\), got \(4, 29\)"):
        ridge.predict(X[rest, 1:], 0.1)
    with pytest.raises(InputError, match="expected a ridge fitted to features"):
        replace(ridge, centre=None, axes=None).predict(X, 0.1)
