"""What varies, and what tells groups apart: by the loop, by law, and on bodies whose difference is known."""

from itertools import combinations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration import (
    cross_collection,
    embed,
    global_variability,
    highlighted,
    pair_energies,
    silhouette,
    within_group,
)
from lssd_learn.operators import delta_energy


def energy(E, alpha):
    return float(alpha @ E @ alpha)


def close(actual, expected, atol=1e-8):
    torch.testing.assert_close(actual, expected, rtol=0, atol=atol)


@given(n=st.integers(2, 7), m=st.integers(1, 5), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_global_variability_maximises_the_sum_over_pairs(random_operators, n, m, seed):
    D = random_operators(n, m, seed)
    functions = global_variability(D, m)
    close(functions.T @ functions, torch.eye(m, dtype=torch.float64))
    scores = [sum(float(delta_energy(D[i], D[j], F)) for i, j in combinations(range(n), 2)) for F in functions.T]
    assert (np.diff(scores) <= 1e-9 * scores[0]).all()
    for other in torch.from_numpy(np.random.default_rng(seed).normal(size=(5, m))):
        other = other / other.norm()
        assert sum(float(delta_energy(D[i], D[j], other)) for i, j in combinations(range(n), 2)) <= scores[0] * (
            1 + 1e-9
        )
    close(global_variability(D), functions[:, 0])


def test_signs_follow_the_rule(random_operators):
    D, groups = random_operators(6, 5), list("aabbcc")
    for functions in (global_variability(D, 5), within_group(D, groups, 5), cross_collection(D, groups, 5, "ratio")):
        assert (functions.max(0).values == functions.abs().max(0).values).all()
        close(functions.norm(dim=0), torch.ones(5, dtype=torch.float64))


@pytest.mark.parametrize("mean", [True, False])
def test_cross_collection_maximises_across_less_within(random_operators, mean):
    D, groups = random_operators(9, 5), list("aaaaaabbb")
    E = pair_energies(D, groups, mean)
    difference = E.across - E.within
    evals, V = torch.linalg.eigh(difference)
    functions = cross_collection(D, groups, 5, mean=mean)
    close((functions * (difference @ functions)).sum(0), evals.flip(0))
    close((functions * V.flip(1)).sum(0).abs(), torch.ones(5, dtype=torch.float64))
    close(cross_collection(D, groups, mean=mean), functions[:, 0])


def test_of_equal_groups_it_is_the_difference_of_means_and_says_so(random_operators, caplog):
    D = random_operators(8, 5)
    apart = D[:4].mean(0) - D[4:].mean(0)
    best = torch.linalg.eigh(apart.T @ apart)[1][:, -1]
    close((cross_collection(D, "aaaabbbb", mean=False) @ best).abs(), torch.tensor(1.0, dtype=torch.float64))
    assert "two groups of 4: summed over pairs, what varies within them is not penalised" in caplog.text
    caplog.clear()
    cross_collection(D, "aaaabbbb", method="ratio")
    cross_collection(D, "aaaabbbb")
    cross_collection(D, "aaaaabbb", mean=False)
    cross_collection(D, "aabbccdd", mean=False)
    assert not caplog.text


def test_the_ratio_solves_the_generalised_eigenproblem(random_operators):
    D, groups = random_operators(7, 4), list("aaaabbb")
    E = pair_energies(D, groups, mean=True)
    within, across = E.within, E.across
    functions = cross_collection(D, groups, 4, "ratio", epsilon=0.1)
    B = within + 0.1 * within.trace() / 4 * torch.eye(4)
    ratios = (functions * (across @ functions)).sum(0) / (functions * (B @ functions)).sum(0)
    assert (ratios.diff() <= 0).all()
    close(across @ functions, B @ functions * ratios)


def test_the_ratio_penalises_nuisance_and_the_summed_difference_does_not():
    """One function is moved by the group, a little; another much, at random, with a chance difference of the means."""
    D = torch.eye(3, dtype=torch.float64).repeat(8, 1, 1)
    D[4:, 1, 1] += 0.5
    D[:, 2, 2] += torch.tensor([3.0, -3, 3, 0, -3, 3, -3, 0])
    assert cross_collection(D, "aaaabbbb", mean=False).abs().argmax() == 2
    assert cross_collection(D, "aaaabbbb").abs().argmax() == 1  # chance is subtracted
    assert cross_collection(D, "aaaabbbb", method="ratio").abs().argmax() == 1
    assert global_variability(D).abs().argmax() == within_group(D, "aaaabbbb").abs().argmax() == 2


def test_means_over_pairs_estimate_the_difference_of_the_means():
    """Whatever the sizes and spreads of the groups: the mean of many draws, to four of its standard deviations."""
    rng, draws = np.random.default_rng(0), []
    for _ in range(500):
        D = torch.from_numpy(rng.normal(size=(10, 3, 3)))
        D[:5] *= 2
        D[5:, 0, 0] += 2
        D[8:, 1, 1] += 3
        E = pair_energies(D, "aaaaabbbcc", mean=True)
        draws.append(E.across - E.within)
    draws = torch.stack(draws)
    expected = torch.diag(torch.tensor([8 / 3, 18 / 3, 0], dtype=torch.float64))  # of a − b, a − c and b − c
    assert ((draws.mean(0) - expected).abs() < 4 * draws.std(0) / 500**0.5).all()


def test_sums_over_pairs_of_unequal_groups_favour_the_nuisance_of_the_smaller():
    D = torch.eye(3, dtype=torch.float64).repeat(12, 1, 1)
    D[9:, 1, 1] += 1
    D[9:, 2, 2] += torch.tensor([2.0, -2, 0])
    groups = ["many"] * 9 + ["few"] * 3
    assert cross_collection(D, groups, mean=False).abs().argmax() == 2
    assert cross_collection(D, groups).abs().argmax() == 1


@pytest.mark.parametrize("method", ["difference", "ratio"])
@pytest.mark.parametrize(("kind", "parameter", "times"), [(0, "bust", 6), (1, "upper_arm", 2.5)])
def test_on_bodies_it_lights_up_where_the_groups_differ(two_groups, method, kind, parameter, times):
    """The mean displacement of vertices, weighted with f², is so many times that of the whole surface."""
    latent, groups, moved = two_groups(parameter)
    D, M = latent.differences(symmetric=True)[kind], latent.bases[0].mass

    def concentration(alpha):
        f = latent.to_shape(alpha, 0).numpy()
        return (M * f**2 * moved).sum() / (M * f**2).sum() / ((M * moved).sum() / M.sum())

    across = concentration(cross_collection(D, groups, method=method))
    assert across > times
    assert across > 1.15 * concentration(global_variability(D))


def test_highlighted_features_separate_bodies_that_operators_do_not(two_groups):
    latent, groups, _ = two_groups("bust")
    area, _ = latent.differences()
    alpha = cross_collection(area, groups)
    assert silhouette(embed(area).points, groups) < 0.3
    assert silhouette(embed(area, alpha=alpha).points, groups) > 0.45


def test_a_few_labels_do(two_groups):
    """Six of twenty bodies are labelled; the features of all separate better than their operators."""
    latent, groups, _ = two_groups("bust")
    area, _ = latent.differences()
    labelled = [i for i in range(20) if i % 10 in (1, 4, 7)]
    few = [label if i in labelled else ("", None)[i % 2] for i, label in enumerate(groups)]
    alpha = cross_collection(area, few)
    close(alpha, cross_collection(area[labelled], [groups[i] for i in labelled]))
    assert silhouette(highlighted(area, alpha), groups) > silhouette(area, groups) + 0.1


def test_highlighted_is_the_action_of_the_operators(random_operators):
    D, functions = random_operators(3, 4), random_operators(1, 4, 1)[0, :, :2]
    expected = torch.stack([X @ functions for X in D])
    close(highlighted(D, functions), expected)
    close(highlighted(D.numpy(), functions[:, 0].numpy()), expected[..., 0])
    assert highlighted(D.float(), functions[:, 0].float()).dtype == torch.float64


def test_the_gauge_turns_the_functions_with_it(random_operators):
    D = random_operators(7, 4)
    R = torch.linalg.qr(random_operators(1, 4, 5)[0])[0]
    for method in ("difference", "ratio"):
        alpha, turned = (cross_collection(X, "aaaabbb", method=method) for X in (D, R.T @ D @ R))
        close((R @ turned @ alpha).abs(), torch.tensor(1.0, dtype=torch.float64))


def test_borders(random_operators):
    D = random_operators(4, 3)
    with pytest.raises(InputError, match="method='best': expected one of difference, ratio"):
        cross_collection(D, "aabb", method="best")
    with pytest.raises(InputError, match="count=4: expected a whole number, 1 to 3"):
        global_variability(D, 4)
    with pytest.raises(InputError, match="epsilon=0: expected a number above 0"):
        cross_collection(D, "aabb", method="ratio", epsilon=0)
    for refused in (lambda: within_group(D, "abcd"), lambda: cross_collection(D, "abcd", method="ratio")):
        with pytest.raises(InputError, match="labels: expected two shapes or more in one of the groups"):
            refused()
    with pytest.raises(InputError, match=r"alpha: expected a function \(3,\) or several \(3, p\), got \(2,\)"):
        highlighted(D, [1.0, 0])
    with pytest.raises(InputError, match="D: expected two operators or more, got 1"):
        global_variability(D[:1])
    assert cross_collection(D[:2], "ab").shape == (3,)  # one pair, and none within
