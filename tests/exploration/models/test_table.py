"""The table of a linear model against scipy's, against permutations one by one, and under what must not matter."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from lssd_learn.errors import InputError
from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.strata import strata

RNG = np.random.default_rng(0)
SEX, LINE = np.array(list("mf") * 9), np.repeat(list("abc"), 6)
SIZE = RNG.uniform(1, 3, 18)
KNOWN = {"sex": SEX, "line": LINE, "size": SIZE}
Y = RNG.normal(size=(18, 5)) + 0.5 * SIZE[:, None]


def by_hand(Y, columns, others, order=None):
    """Sum of squares of some columns beside others, and of the residuals of both, by least squares."""
    R, X = np.column_stack([np.ones(len(Y)), *others]), np.column_stack([np.ones(len(Y)), *others, *columns])

    def left(X, Y):
        return np.square(Y - X @ np.linalg.lstsq(X, Y, rcond=None)[0]).sum()

    fitted = R @ np.linalg.lstsq(R, Y, rcond=None)[0]
    made = Y if order is None else fitted + (Y - fitted)[list(order)]
    return left(R, made) - left(X, made), left(X, made)


def test_one_factor_is_the_analysis_of_variance(modelled):
    y = Y[:, :1]
    row = modelled(y, "~ line", KNOWN).row("line")
    assert pytest.approx(stats.f_oneway(*(y[line == LINE, 0] for line in "abc")).statistic, rel=1e-12) == row.F
    assert row.df == 2


def test_one_number_is_a_regression(modelled):
    found, known = modelled(Y[:, :1], "~ size", KNOWN).row("size"), stats.linregress(SIZE, Y[:, 0])
    assert pytest.approx(known.rvalue**2, rel=1e-12) == found.R2
    assert pytest.approx((known.slope / known.stderr) ** 2, rel=1e-12) == found.F


def test_pairs_are_the_paired_t_test_and_every_flip_of_their_signs(modelled):
    d = RNG.normal(0.6, 1, 7)
    person, state = np.repeat(np.arange(7), 2), np.array(["before", "after"] * 7)
    y = 5 * RNG.normal(size=7)[person] + np.where(state == "after", d[person], 0)
    row = modelled(y[:, None], "~ state", {"state": state}, person, permutations=999).row("state")
    assert pytest.approx(stats.ttest_1samp(d, 0).statistic ** 2, rel=1e-9) == row.F
    flipped = np.array([abs(np.dot(signs, d)) for signs in product([-1, 1], repeat=7)])
    assert row.chance.p == (flipped >= abs(d.sum()) - 1e-9).mean()
    assert row.chance.smallest == 2 / 2**7


@pytest.mark.parametrize("kind", ["I", "II", "III"])
def test_permutations_one_by_one(modelled, kind):
    """Of five shapes there are 120, and each is fitted by least squares as it stands in the books."""
    Y, size, age = RNG.normal(size=(5, 3)), RNG.uniform(1, 2, 5), RNG.uniform(1, 2, 5)
    table = modelled(Y, "~ size + age", {"size": size, "age": age}, kind=kind, permutations=120)
    others = {"size": [] if kind == "I" else [age], "age": [size]}
    for name, column in (("size", size), ("age", age)):
        F = []
        for order in permutations(range(5)):
            term, _ = by_hand(Y, [column], others[name], order)
            R = np.column_stack([np.ones(5), *others[name]])
            fitted = R @ np.linalg.lstsq(R, Y, rcond=None)[0]
            _, left = by_hand(fitted + (Y - fitted)[list(order)], [size, age], [])
            F.append(term / (left / 2))
        np.testing.assert_allclose(np.sort(table.row(name).chance.found), np.sort(F), rtol=1e-9)
        assert pytest.approx(F[0]) == table.row(name).F


def test_types_of_sums_with_an_interaction(modelled):
    """Unbalanced, so that all three differ; of type III by the columns of sums to zero."""
    some = np.r_[0:11, 13:18]
    y, known = Y[some], {name: values[some] for name, values in KNOWN.items()}
    sex = np.where(SEX[some] == "m", -1.0, 1.0)
    line = np.stack([(LINE[some] == one) * 1.0 - (LINE[some] == "c") for one in "ab"], 1)
    both = sex[:, None] * line
    expected = {
        "I": ([sex], [], [line], [sex], [both], [sex, line]),
        "II": ([sex], [line], [line], [sex], [both], [sex, line]),
        "III": ([sex], [line, both], [line], [sex, both], [both], [sex, line]),
    }
    for kind, (a, ra, b, rb, c, rc) in expected.items():
        table = modelled(y, "~ sex * line", known, kind=kind)
        for name, columns, others in (("sex", a, ra), ("line", b, rb), ("sex:line", c, rc)):
            assert pytest.approx(by_hand(y, columns, others)[0], rel=1e-9) == table.row(name).SS, (kind, name)


def test_balanced_and_orthogonal_all_types_are_one_and_sums_add_up(modelled):
    tables = [modelled(Y, "~ sex * line", KNOWN, kind=kind) for kind in ("I", "II", "III")]
    for rows in zip(*(table.terms for table in tables), strict=True):
        np.testing.assert_allclose([row.SS for row in rows], rows[0].SS, rtol=1e-9)
    uneven = modelled(Y[1:], "~ size + sex * line", {name: v[1:] for name, v in KNOWN.items()})
    parts = [row.SS for row in uneven.terms] + [uneven.rest["residuals"][1]]
    assert sum(parts) == pytest.approx(uneven.rest["total"][1], rel=1e-12)
    assert sum(row.df for row in uneven.terms) + uneven.rest["residuals"][0] == 16


def test_sums_of_strata_add_up(modelled):
    who = np.repeat(np.arange(6), 3)
    known = {"state": np.array(list("xyz") * 6), "sex": np.repeat(list("mf"), 9), "size": SIZE}
    table = modelled(Y, "~ size + sex + state", known, who)
    assert [row.term for row in table.terms] == ["size (between person)", "sex", "size", "state"]
    parts = [row.SS for row in table.terms] + [SS for name, (_, SS, _) in table.rest.items() if name != "total"]
    assert sum(parts) == pytest.approx(table.rest["total"][1], rel=1e-12)
    free = [row.df for row in table.terms] + [df for name, (df, _, _) in table.rest.items() if name != "total"]
    assert sum(free) == 17
    moved = Y + RNG.normal(size=(6, 5))[who]  # what people differ by plays no part within them
    again = modelled(moved, "~ size + sex + state", known, who)
    for name in ("size", "state"):
        np.testing.assert_allclose(again.row(name).chance.found, table.row(name).chance.found, rtol=1e-9)
    assert pytest.approx(table.row("sex").F) != again.row("sex").F


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["I", "II", "III"]), st.floats(0.01, 100))
def test_rotating_the_vectors_and_scaling_a_number_change_nothing(seed, kind, scale):
    from lssd_learn.exploration.models.table import model_table

    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    known = {"sex": SEX.astype(object), "line": LINE.astype(object), "size": SIZE}
    found = []
    for values, size in ((Y, SIZE), (3 + 7 * Y @ turn, 5 - scale * SIZE)):
        made = design("~ size + line + sex", known | {"size": size}, SEX)
        found.append(model_table(values, made, strata(made, None, "", 29, seed), kind))
    for one, other in zip(*(table.terms for table in found), strict=True):
        np.testing.assert_allclose(other.chance.found, one.chance.found, rtol=1e-7)
        assert other.chance.p == one.chance.p
        assert pytest.approx(one.R2) == other.R2


def test_few_permutations_are_all_taken(modelled):
    y = np.arange(6.0)[:, None]
    row = modelled(y, "~ group", {"group": list("aaabbb")}).row("group")
    assert len(row.chance.found) == 20
    assert row.chance.p == row.chance.smallest == 2 / 20


@pytest.mark.parametrize(
    ("formula", "known", "message"),
    [
        ("~ sex + C(sex)", {}, r"say something of their own, .*; C\(sex\) does not"),
        ("~ line * poly(size, 14)", {}, "leave no residuals beside 17 columns"),
        ("~ log(size - 1.5)", {}, r"expected numbers, got (nan|-inf) for shape_"),
        ("~ 0 + sex", {}, "expected a model with an intercept"),
        ("~ other", {"other": ["a"] * 18}, "expected two levels or more of other, got 'a' alone"),
        ("y ~ sex", {}, "expected a formula, such as"),
    ],
)
def test_mistakes(modelled, formula, known, message):
    with pytest.raises(InputError, match=message):
        modelled(Y, formula, KNOWN | known)
