"""Closed forms against loops over pairs."""

from itertools import combinations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration import pair_energies
from lssd_learn.exploration.pairs import coded_energies


def loop(D, groups):
    """The slow, obvious twin."""
    within, across, counts = torch.zeros_like(D[0]), torch.zeros_like(D[0]), [0, 0]
    for i, j in combinations(range(len(D)), 2):
        if groups[i] is None or groups[j] is None:
            continue
        H = (D[i] - D[j]).T @ (D[i] - D[j])
        if groups[i] == groups[j]:
            within, counts[0] = within + H, counts[0] + 1
        else:
            across, counts[1] = across + H, counts[1] + 1
    return within, across, counts


@given(groups=st.lists(st.sampled_from(["a", "b", "c", None]), min_size=2, max_size=9), seed=st.integers(0, 10**6))
@settings(max_examples=50, deadline=None)
def test_they_are_the_sums_over_pairs(random_operators, groups, seed):
    D = random_operators(len(groups), 4, seed)
    if len(set(groups) - {None}) < 2:
        with pytest.raises(InputError, match="labels: expected two groups or more, got [01]$"):
            pair_energies(D, groups)
        return
    found = pair_energies(D, groups)
    within, across, counts = loop(D, groups)
    torch.testing.assert_close(found.within, within, rtol=0, atol=1e-9)
    torch.testing.assert_close(found.across, across, rtol=0, atol=1e-9)
    assert [found.within_pairs, found.across_pairs] == counts


@given(groups=st.lists(st.sampled_from("abc"), min_size=2, max_size=9), seed=st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_means_are_over_pairs_and_then_over_groups(random_operators, groups, seed):
    D, names = random_operators(len(groups), 3, seed), sorted(set(groups))
    if len(names) < 2:
        return
    found, zero = pair_energies(D, groups, mean=True), torch.zeros(3, 3, dtype=torch.float64)
    parts = {name: D[[g == name for g in groups]] for name in names}

    def mean(pairs):
        return sum(((a - b).T @ (a - b) for a, b in pairs), zero) / max(len(pairs), 1)

    within = [mean(list(combinations(X, 2))) for X in parts.values() if len(X) > 1]
    across = [mean([(a, b) for a in parts[g] for b in parts[h]]) for g, h in combinations(names, 2)]
    torch.testing.assert_close(found.within, sum(within, zero) / max(len(within), 1), rtol=0, atol=1e-9)
    torch.testing.assert_close(found.across, sum(across) / len(across), rtol=0, atol=1e-9)


@given(n=st.integers(1, 6), seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_of_two_equal_groups_the_difference_is_that_of_the_sums(random_operators, n, seed):
    D = random_operators(2 * n, 4, seed)
    found = pair_energies(D, ["a", "b"] * n)
    apart = D[::2].sum(0) - D[1::2].sum(0)
    torch.testing.assert_close(found.across - found.within, apart.T @ apart, rtol=0, atol=1e-9)


def test_many_groupings_at_once_are_each_alone(random_operators):
    D = random_operators(7, 3)
    codes = torch.tensor([[0, 0, 1, 2, 2, 2, 1], [2, 1, 0, 0, 1, 2, 2]])
    many = coded_energies(D, codes, 3)
    for i, row in enumerate(codes):
        within, across, _ = loop(D, row.tolist())
        torch.testing.assert_close(many.within[i], within, rtol=0, atol=1e-10)
        torch.testing.assert_close(many.across[i], across, rtol=0, atol=1e-10)


def test_what_all_operators_share_does_not_cost_digits(random_operators):
    D = random_operators(6, 3)
    groups = ["a", "b"] * 3
    found, shifted = pair_energies(D, groups), pair_energies(D + 1e6, groups)
    torch.testing.assert_close(shifted.within, found.within, rtol=0, atol=1e-7)
    torch.testing.assert_close(shifted.across, found.across, rtol=0, atol=1e-7)


@pytest.mark.parametrize("none", [None, "", np.nan, float("nan"), np.float64("nan")])
def test_labels_of_every_kind_and_of_none(random_operators, none):
    D = random_operators(5, 3)
    expected = pair_energies(D[:4], "aabb")
    for groups in (
        ["x", "x", "y", "y", none],
        [1, 1, 0, 0, none],
        np.array([True, True, False, False, none], dtype=object),
    ):
        torch.testing.assert_close(pair_energies(D, groups).across, expected.across)
    torch.testing.assert_close(pair_energies(D[:4], torch.tensor([3, 3, 1, 1])).within, expected.within)


def test_borders(random_operators):
    with pytest.raises(InputError, match="labels: expected one for each of 3 shapes, got 2"):
        pair_energies(random_operators(3, 2), ["a", "b"])
    with pytest.raises(InputError, match=r"D: expected operators \(n, m, m\), got \(2, 2\)"):
        pair_energies(np.eye(2), ["a", "b"])
