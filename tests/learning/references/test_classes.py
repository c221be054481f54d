import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.learning import Split, linear_reference, majority_reference, operator_features, split


@pytest.fixture
def problem():
    """Three noisy clusters in forty dimensions: (features, labels, split)."""
    generator = np.random.default_rng(0)
    labels = generator.integers(3, size=150)
    features = 2 * generator.normal(size=(3, 40))[labels] + 2 * generator.normal(size=(150, 40)) + 5
    return features, labels, split(150, 0)


def test_majority_is_that_of_the_training_split():
    labels = np.array([0, 1, 1, 0, 0, 0, 2])
    parts = Split(train=np.array([0, 1, 2]), test=np.array([3, 4, 5, 6, 1]), validation=np.array([6]))
    assert majority_reference(labels, parts).accuracy == 1 / 5


def test_linear_is_that_of_the_normal_equations(problem):
    features, labels, parts = problem
    reference = linear_reference(features, labels, parts)
    indicators = np.eye(3)[labels]
    centre, mean = features[parts.train].mean(0), indicators[parts.train].mean(0)
    X = features[parts.train] - centre
    alpha = reference.alpha * np.trace(X.T @ X) / min(X.shape)
    B = np.linalg.solve(X.T @ X + alpha * np.eye(40), X.T @ (indicators[parts.train] - mean))
    answers = ((features[parts.test] - centre) @ B + mean).argmax(1)
    assert reference.accuracy == np.mean(answers == labels[parts.test]) > 0.9


def test_linear_chooses_the_most_accurate_on_validation(problem):
    features, labels, parts = problem
    alphas = np.logspace(-6, 3, 10)
    chosen = linear_reference(features, labels, parts, alphas).alpha
    swapped = Split(train=parts.train, test=parts.validation, validation=parts.validation)
    scores = {alpha: linear_reference(features, labels, swapped, [alpha]).accuracy for alpha in alphas}
    assert scores[chosen] == max(scores.values())


def test_linear_does_not_look_at_the_test_split(problem):
    features, labels, parts = problem
    other = labels.copy()
    other[parts.test] = 0
    assert linear_reference(features, labels, parts).alpha == linear_reference(features, other, parts).alpha


def test_linear_is_right_where_classes_are_linear(collection):
    operators, parameters = collection
    labels = (parameters[:, 0] > 0.5).astype(int)
    assert linear_reference(operator_features(operators), labels, split(60, 0)).accuracy >= 8 / 9


def test_constant_features_answer_the_majority(problem):
    _, labels, parts = problem
    features = np.ones((150, 3))
    assert linear_reference(features, labels, parts).accuracy == majority_reference(labels, parts).accuracy


def test_errors(problem):
    features, labels, parts = problem
    with pytest.raises(InputError, match=r"features must be \(150, d\), got \(149, 40\)"):
        linear_reference(features[1:], labels, parts)
    for wrong in (labels / 2, labels[:, None], labels - 1):
        with pytest.raises(InputError, match=r"labels must be \(n,\) integers from 0, got "):
            majority_reference(wrong, parts)
