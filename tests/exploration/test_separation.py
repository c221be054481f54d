"""How well groups are told apart: by hand, against loops, and where there is nothing to tell."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration import (
    cross_collection,
    few_labels_accuracy,
    held_out_accuracy,
    highlighted,
    nearest_accuracy,
    pair_energies,
    permutation_test,
    silhouette,
)

LABELS = st.lists(st.sampled_from(["a", "b", "c", ""]), min_size=2, max_size=9)


@given(labels=LABELS, seed=st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_silhouette_and_nearest_neighbours_by_loops(labels, seed):
    x = np.random.default_rng(seed).normal(size=(len(labels), 2))
    known = [i for i, label in enumerate(labels) if label]
    if len({labels[i] for i in known}) < 2:
        with pytest.raises(InputError, match="labels: expected two groups or more"):
            silhouette(x, labels)
        return
    scores, hits = [], []
    for i in known:
        away = {j: np.linalg.norm(x[i] - x[j]) for j in known if j != i}
        means = {g: [d for j, d in away.items() if labels[j] == g] for g in set(labels) - {""}}
        a, b = means[labels[i]], min(np.mean(means[g]) for g in means if g != labels[i] and means[g])
        scores.append((b - np.mean(a)) / max(b, np.mean(a)) if a else 0)
        hits.append(labels[min(away, key=away.get)] == labels[i])
    assert silhouette(x, labels) == pytest.approx(np.mean(scores))
    assert nearest_accuracy(torch.from_numpy(x), labels) == pytest.approx(np.mean(hits))


def test_far_groups_score_one_and_equal_points_zero():
    x = [[0.0], [0.1], [100], [100.1]]
    assert silhouette(x, "aabb") > 0.99
    assert nearest_accuracy(x, "aabb") == 1
    assert silhouette(x, "abab") < 0
    assert nearest_accuracy(x, "abab") == 0
    assert silhouette(np.zeros((4, 2)), "aabb") == 0


def features(n, m, shift, seed=0):
    """Operators of two groups, n each, whose means differ by `shift` in one entry."""
    D = torch.from_numpy(np.random.default_rng(seed).normal(size=(2 * n, m, m)))
    D[n:, 0, 0] += shift
    return D, ["a"] * n + ["b"] * n


@pytest.mark.parametrize("method", ["difference", "ratio"])
def test_the_permutation_test_is_a_loop_over_groupings(method):
    D, groups = features(5, 3, 1)
    found = permutation_test(D, groups, 20, seed=3, method=method)
    codes = np.repeat([0, 1], 5)
    rows = np.random.default_rng(3).permuted(np.tile(codes, (20, 1)), axis=1)
    for value, row in zip([found.statistic, *found.permuted.tolist()], [codes, *rows], strict=True):
        alpha, E = cross_collection(D, row, method=method), pair_energies(D, row, mean=True)
        assert value == pytest.approx(float((alpha @ E.across @ alpha) / (alpha @ E.within @ alpha)))
    assert found.p_value == pytest.approx((1 + (found.permuted.numpy() >= found.statistic).sum()) / 21)


def test_the_same_seed_gives_the_same_bits():
    D, groups = features(5, 3, 1)
    a, b, c = (permutation_test(D, groups, 200, seed) for seed in (0, 0, 1))
    assert torch.equal(a.permuted, b.permuted)
    assert not torch.equal(a.permuted, c.permuted)


@pytest.mark.parametrize("method", ["difference", "ratio"])
def test_p_is_uniform_where_there_is_nothing_and_small_where_there_is(method):
    """Though the function of the very grouping separates features of pure noise, too."""
    noise = [permutation_test(*features(6, 4, 0, seed), 99, seed, method).p_value for seed in range(60)]
    assert 0.35 < np.mean(noise) < 0.65
    assert np.mean(np.array(noise) <= 0.1) < 0.25
    assert permutation_test(*features(6, 4, 5), 99, method=method).p_value == pytest.approx(0.01)
    D, groups = features(6, 20, 0)
    assert silhouette(highlighted(D, cross_collection(D, groups, method=method)), groups) > 0.02


def test_held_out_accuracy_does_not_flatter():
    """On noise half of the shapes are right; with all labels seen, many more."""
    flattered, honest = [], []
    for seed in range(6):
        D, groups = features(8, 12, 0, seed)
        flattered.append(nearest_accuracy(highlighted(D, cross_collection(D, groups, method="ratio")), groups))
        honest.append(held_out_accuracy(D, groups, "ratio"))
    assert np.mean(honest) < 0.62
    assert np.mean(flattered) > np.mean(honest) + 0.15
    D, groups = features(8, 4, 30)
    assert held_out_accuracy(D, [*groups[:-1], ""]) == 1


def test_identical_shapes_are_no_difference():
    D = torch.eye(3, dtype=torch.float64).repeat(6, 1, 1)
    for method in ("difference", "ratio"):
        assert permutation_test(D, "aaabbb", 19, method=method).p_value == 1


@pytest.mark.slow
def test_on_bodies_the_difference_is_no_chance(two_groups):
    latent, groups, _ = two_groups("bust")
    area, _ = latent.differences()
    shuffled = np.random.default_rng(0).permutation(groups)
    assert permutation_test(area, groups, 199).p_value < 0.03
    assert permutation_test(area, shuffled, 199).p_value > 0.1
    assert held_out_accuracy(area, groups) >= 0.8
    assert held_out_accuracy(area, shuffled) < 0.8


def test_borders():
    D, groups = features(3, 2, 0)
    with pytest.raises(InputError, match="permutations=0: expected a whole number, 1 or more"):
        permutation_test(D, groups, 0)
    with pytest.raises(InputError, match="seed=-1: expected a whole number"):
        permutation_test(D, groups, 9, -1)
    with pytest.raises(InputError, match="got 6 of 6 shapes"):
        permutation_test(D, "abcdef")
    with pytest.raises(InputError, match="method='t': expected one of difference, ratio"):
        permutation_test(D, groups, method="t")
    with pytest.raises(InputError, match="labels: expected two groups or more, got 1"):
        nearest_accuracy(D, "aaaaaa")


def few_by_loops(D, labels, few, seed, count, method):
    """One draw."""
    codes = np.unique(labels, return_inverse=True)[1]
    rng = np.random.default_rng(seed)
    kept = [i for g in (0, 1) for i in rng.permutation(np.flatnonzero(codes == g))[:few]]
    known = [labels[i] if i in kept else None for i in range(len(D))]
    features = [D_i @ cross_collection(D, known, count, method) for D_i in D]
    asked = [i for i in range(len(D)) if i not in kept]
    nearest = [min(kept, key=lambda j, i=i: float((features[i] - features[j]).norm())) for i in asked]
    return np.mean([labels[i] == labels[j] for i, j in zip(asked, nearest, strict=True)])


@pytest.mark.parametrize(("count", "method"), [(1, "difference"), (2, "ratio")])
def test_a_few_labels_by_loops(random_operators, count, method):
    labels = list("aaaaabbbbbb")
    D = random_operators(11, 4)
    D[5:, 1, 1] += 2
    for seed in range(3):
        found = few_labels_accuracy(D, labels, 2, 1, seed, method, count=count)
        assert found == pytest.approx(few_by_loops(D, labels, 2, seed, count, method))
    D[5:, 1, 1] += 20
    assert few_labels_accuracy(D, labels, 3) == 1


def test_too_many_are_labelled(random_operators):
    with pytest.raises(InputError, match="few=2: expected less than 2, the shapes of the smallest group"):
        few_labels_accuracy(random_operators(5, 3), "aabbb", 2)
