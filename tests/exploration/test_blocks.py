"""Labels permuted by blocks: what may be exchanged, every grouping once, and the level of the test."""

from itertools import product

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.exploration import few_labels_accuracy, held_out_accuracy, nearest_accuracy, permutation_test
from lssd_learn.exploration.blocks import Design, block_codes, paired_energies, within_blocks


def people(scans, m=3, between=1.0, within=0.05, seed=0):
    """Operators of people, of whom each has so many scans, and who is on them."""
    rng = np.random.default_rng(seed)
    of = np.repeat(np.arange(len(scans)), scans)
    D = between * rng.normal(size=(len(scans), m, m))[of] + within * rng.normal(size=(len(of), m, m))
    return torch.from_numpy(D), of


def test_whole_blocks_are_exchanged_for_blocks_as_large():
    _, who = people([2, 2, 2, 3, 3, 4])
    labels = np.array([0, 0, 1, 0, 1, 1])[who]
    design = Design.of_labels(labels, who)
    groupings, exact = design.groupings(99, 0)
    assert exact
    assert len(groupings) == design.count == 3 * 2
    assert (groupings[0] == labels).all()
    assert len({tuple(row) for row in groupings}) == 6
    for row in groupings:
        assert all(len(set(row[who == person])) == 1 for person in range(6))
        assert (row[who == 5] == 1).all()  # alone of its size
        assert np.bincount(row).tolist() == np.bincount(labels).tolist()
    assert str(design) == (
        "5 blocks exchanged whole for blocks as large (2, 3 shapes); "
        "1 blocks kept as they are, since none of another group is as large"
    )


def test_a_block_of_several_groups_is_permuted_within():
    who = np.repeat([0, 1, 2, 3], [2, 3, 2, 2])
    labels = np.array([0, 1, 0, 0, 1, 0, 0, 1, 1])
    design = Design.of_labels(labels, who)
    groupings, exact = design.groupings(99, 0)
    assert exact
    assert len(groupings) == 2 * 3 * 2
    assert all(sorted(row[who == b]) == sorted(labels[who == b]) for row in groupings for b in (0, 1))
    assert {tuple(row[5:]) for row in groupings} == {(0, 0, 1, 1), (1, 1, 0, 0)}
    random, exact = design.groupings(11, 0)
    assert not exact
    assert random.shape == (12, 9)
    assert {tuple(row) for row in random} <= {tuple(row) for row in groupings}


def test_a_shape_without_a_block_is_one_of_its_own():
    codes = block_codes(["a", None, "a", "", np.nan], 5)
    assert codes[0] == codes[2]
    assert len(set(codes)) == 4


def test_pairs_flip_the_signs_of_their_differences():
    D, who = people([2] * 5, within=1)
    labels = np.tile([0, 1], 5)
    found = permutation_test(D, labels, blocks=who)
    d = (D[1::2] - D[::2]).flatten(1)

    def energy(signs):
        signed = torch.tensor(signs, dtype=D.dtype)[:, None] * d
        return float(sum(signed[b] @ signed[c] for b in range(5) for c in range(5) if b != c) / 20)

    assert found.exact
    assert found.statistic == pytest.approx(energy([1] * 5))
    every = [energy(signs) for signs in product([-1, 1], repeat=5)]
    np.testing.assert_allclose(sorted([found.statistic, *found.permuted.tolist()]), sorted(every))
    assert found.smallest == 2 / 32
    assert found.p_value == pytest.approx(np.mean(np.array(every) >= found.statistic - 1e-9))


def test_the_energy_of_the_mean_is_unbiased_and_does_not_see_what_blocks_differ_by():
    labels, found = np.tile([0, 1, 1], 6), []
    for seed in range(200):
        D, who = people([3] * 6, within=1, seed=seed)
        design = Design.of_labels(labels, who)
        found.append(float(paired_energies(D, design, labels[None])[0]))
        moved = D + torch.from_numpy(np.random.default_rng(seed).normal(size=(6, 3, 3))[who])
        assert float(paired_energies(moved, design, labels[None])[0]) == pytest.approx(found[-1])
    assert abs(np.mean(found)) < 3 * np.std(found) / np.sqrt(200)


def test_people_grouped_at_random_are_no_two_kinds():
    """Without blocks most such groupings of people would be significant."""
    without, within = [], []
    for seed in range(60):
        D, who = people([4] * 8, seed=seed)
        labels = np.random.default_rng(seed).permutation([0, 1] * 4)[who]
        without.append(permutation_test(D, labels, 99, seed).p_value)
        within.append(permutation_test(D, labels, 99, seed, blocks=who).p_value)
    assert np.mean(np.array(without) <= 0.05) > 0.5
    assert np.mean(np.array(within) <= 0.05) < 0.15
    assert 0.35 < np.mean(within) < 0.65


def test_what_two_poses_differ_by_is_found_though_people_differ_more():
    D, who = people([2] * 10)
    labels = np.tile(["sits", "stands"], 10)
    D[1::2, 0, 0] += 0.1
    assert permutation_test(D, labels).p_value > 0.5
    assert permutation_test(D, labels, blocks=who).p_value < 0.01


def test_both_kinds_of_blocks_count():
    """Of nine pairs and of ten people who were seen once in one group: either would be enough."""
    D, who = people([2] * 9 + [1] * 10, between=0.3)
    labels = np.array([0, 1] * 9 + [0] * 5 + [1] * 5)
    assert permutation_test(D, labels, 499, blocks=who).p_value > 0.05
    for some in (np.arange(1, 18, 2), np.arange(23, 28)):
        moved = D.clone()
        moved[some, 0, 0] += 2
        assert permutation_test(moved, labels, 499, blocks=who).p_value < 0.03


def test_whole_blocks_are_left_out():
    D, who = people([4] * 10)
    chances = []
    for seed in range(10):
        labels = np.random.default_rng(seed).permutation([0, 1] * 5)[who]
        assert nearest_accuracy(D, labels) == 1
        assert held_out_accuracy(D, labels, blocks=np.arange(40)) == held_out_accuracy(D, labels)
        found = (nearest_accuracy(D, labels, who), held_out_accuracy(D, labels, blocks=who),
                 few_labels_accuracy(D, labels, 4, blocks=who))  # fmt: skip
        chances.append(found)
    assert held_out_accuracy(D, labels) > 0.95
    assert (np.mean(chances, axis=0) < 0.65).all()


def test_nothing_to_permute_is_an_error():
    D, who = people([2, 2, 3, 3])
    labels = np.repeat([0, 1], [4, 6])
    with pytest.raises(InputError, match=r"nothing to permute in 4 blocks \(2 of 2, 2 of 3 shapes\)"):
        permutation_test(D, labels, blocks=who)
    with pytest.raises(InputError, match="labels: expected one for each of 10 shapes, got 3"):
        permutation_test(D, labels, blocks=[1, 2, 3])
    with pytest.raises(InputError, match="blocks: expected two or more of each kind"):
        few_labels_accuracy(D[:4], [0, 0, 1, 1], 1, blocks=[0, 0, 1, 1])


def test_within_blocks_only_what_differs_within_them_is_left():
    D, who = people([3, 3, 2, 2])
    labels = [0, 0, 1, 0, 1, None, 0, 0, 1, 1]
    moved = within_blocks(D, labels, who)
    for person in (0, 1):
        assert torch.allclose(moved[who == person].mean(0), D.mean(0))
        assert torch.allclose((moved - D)[who == person], (moved - D)[who == person][:1])
    assert torch.equal(moved[who > 1], D[who > 1])
