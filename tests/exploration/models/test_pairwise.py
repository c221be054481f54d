"""Means, slopes and variances of groups in pairs, by hand."""

from itertools import permutations

import numpy as np
import pytest
from scipy import stats

from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.pairwise import compare_pairs, rows
from lssd_learn.exploration.models.strata import strata

RNG = np.random.default_rng(2)
LINE, SIZE = np.array(list("abc") * 7), RNG.uniform(1, 2, 21)


def compared(Y, formula, known, blocks=None, permutations=199):
    known = {name: v.astype(object) if v.dtype.kind == "U" else v for name, v in known.items()}
    made = design(formula, known, [""] * len(Y))
    return compare_pairs(Y - Y.mean(0), made, strata(made, blocks, "person", permutations, 0))


def by(found, what, pair):
    return next(one for one in found if (one.what, one.pair) == (what, pair))


def test_least_squares_means_of_groups_beside_a_number():
    Y = RNG.normal(size=(21, 4))
    found = compared(Y, "~ size + line", {"size": SIZE, "line": LINE})
    X = np.column_stack([SIZE, *[(one == LINE) * 1.0 for one in "abc"]])
    B = np.linalg.lstsq(X, Y, rcond=None)[0]
    for g, h in ((1, 2), (1, 3), (2, 3)):
        one = by(found, "distance", f"{'abc'[h - 1]} - {'abc'[g - 1]}")
        assert one.value == pytest.approx(np.linalg.norm(B[h] - B[g]))
    assert by(found, "distance", "1 sd of size").value == pytest.approx(SIZE.std(ddof=1) * np.linalg.norm(B[0]))


def test_slopes_of_groups_their_distance_and_angle():
    slopes = {"a": [1.0, 0, 0], "b": [0, 2.0, 0], "c": [3.0, 0, 0]}
    Y = SIZE[:, None] * np.array([slopes[one] for one in LINE]) + 1e-6 * RNG.normal(size=(21, 3))
    found = compared(Y, "~ size * line", {"size": SIZE, "line": LINE})
    assert by(found, "distance", "b - a, 1 sd of size").value == pytest.approx(SIZE.std(ddof=1) * 5**0.5, abs=1e-4)
    assert by(found, "angle in degrees", "b - a, 1 sd of size").value == pytest.approx(90, abs=1e-3)
    assert by(found, "angle in degrees", "c - a, 1 sd of size").value == pytest.approx(0, abs=1e-3)
    assert by(found, "angle in degrees", "b - a, 1 sd of size").chance.p == 1 / 200
    assert by(found, "angle in degrees", "c - a, 1 sd of size").chance.p > 0.5


def test_two_groups_are_as_sure_as_the_table(modelled):
    Y, sex = RNG.normal(size=(8, 3)), np.array(list("mf") * 4)
    distance = by(compared(Y, "~ sex", {"sex": sex}), "distance", "m - f").chance
    row = modelled(Y, "~ sex", {"sex": sex}, permutations=199).row("sex").chance
    assert (distance.p, distance.smallest) == (row.p, row.smallest)


def test_variances_of_groups_are_unbiased_and_permuted():
    Y, group = RNG.normal(size=(5, 2)), np.array(list("aabbb"))
    one = by(compared(Y, "~ group", {"group": group}), "difference of variances", "b - a")
    known = [Y[group == label].var(0, ddof=1).sum() for label in "ab"]
    assert one.value == pytest.approx(known[1] - known[0])
    squares = np.concatenate([np.square(Y[group == g] - Y[group == g].mean(0)).sum(1) for g in "ab"])
    squares /= np.repeat([1 / 2, 2 / 3], [2, 3])
    every = {frozenset(order[:2]): abs(squares[list(order[:2])].mean() - squares[list(order[2:])].mean())
             for order in permutations(range(5))}  # fmt: skip
    assert one.chance.p == np.mean(np.array(list(every.values())) >= abs(one.value) - 1e-12)


def test_of_pairs_the_mean_of_their_differences():
    person, state = np.repeat(np.arange(6), 2), np.array(["x", "y"] * 6)
    Y = 5 * RNG.normal(size=(6, 3))[person] + RNG.normal(size=(12, 3))
    one = by(compared(Y, "~ state", {"state": state}, person), "distance", "y - x")
    assert one.value == pytest.approx(np.linalg.norm((Y[1::2] - Y[::2]).mean(0)))


def test_p_of_several_pairs_is_corrected():
    Y = RNG.normal(size=(21, 4))
    found = rows("area", compared(Y, "~ line", {"line": LINE}))
    assert len(found) == 6
    assert all(row["p corrected"] >= row["p"] for row in found)
    assert all(np.isfinite(row["Z"]) for row in found)


def test_p_of_independent_statistics_is_that_of_the_least():
    from lssd_learn.exploration.models.effects import corrected

    found = RNG.permuted(np.tile(np.arange(1000.0), (3, 1)), axis=1)
    found[0] = np.roll(found[0], -int(found[0].argmax()))  # the largest of the first is that of the data
    assert corrected(found)[0] == pytest.approx(0.003, abs=0.001)
    ranked = stats.rankdata(-found[1])[0] / 1000
    assert corrected(found)[1] == pytest.approx(1 - (1 - ranked) ** 3, abs=0.05)
