"""The model at every point, against scipy's and against permutations one by one."""

from itertools import permutations

import numpy as np
import pytest
import torch
from scipy import stats
from scipy.sparse import csr_array

from lssd_learn.exploration.models.clusters import Cells, enhanced
from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.effects import Chance
from lssd_learn.exploration.models.points import anywhere, local_sizes, term_fields
from lssd_learn.exploration.models.strata import strata
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import stack_differences
from lssd_learn.shapes import eigenbasis

RNG = np.random.default_rng(1)
MASS = RNG.uniform(1, 2, 30)
LINE = np.column_stack([np.arange(29), np.arange(1, 30)])
CELLS = Cells(np.arange(30), MASS / MASS.sum(), LINE, csr_array(np.eye(30)))  # thirty points on a line


def fields(S, formula, known, blocks=None, permutations=199, seed=0):
    known = {name: np.asarray(values) for name, values in known.items()}
    known = {name: v.astype(object if v.dtype.kind in "UO" else float) for name, v in known.items()}
    made = design(formula, known, [str(i) for i in range(len(known[next(iter(known))]))])
    parts = strata(made, blocks, "person", permutations, seed)
    return {term.name: term_fields(S, made, term, parts[-1], MASS, CELLS) for term in made.terms}


def test_two_groups_are_the_t_test_and_a_number_is_a_regression():
    S, size = RNG.normal(size=(12, 30)), RNG.uniform(size=12)
    group = np.array(list("ab") * 6)
    found = fields({"area": S}, "~ group", {"group": group})["group"]["area"][0]
    known = stats.ttest_ind(S[group == "b"], S[group == "a"])
    assert found.title == "b - a"
    np.testing.assert_allclose(found.statistic, known.statistic, rtol=1e-9)
    np.testing.assert_allclose([found.low, found.high], known.confidence_interval(), rtol=1e-9)
    slope = fields({"area": S}, "~ size", {"size": size})["size"]["area"][0]
    known = [size.std(ddof=1) * stats.linregress(size, s).slope for s in S.T]
    np.testing.assert_allclose(slope.effect, known, rtol=1e-9)


def test_slopes_of_groups_are_compared_and_three_groups_in_pairs():
    size, line = RNG.uniform(size=18), np.array(list("abc") * 6)
    slopes = {"a": 1.0, "b": 3.0, "c": 2.5}
    S = np.array([slopes[one] for one in line])[:, None] * size[:, None] + 1e-6 * RNG.normal(size=(18, 30))
    found = fields({"area": S}, "~ size * line", {"size": size, "line": line})
    sd = size.std(ddof=1)
    assert {f.title: round(float(f.effect[0] / sd), 3) for f in found["size:line"]["area"]} == {
        "b - a, 1 sd of size": 2,
        "c - a, 1 sd of size": 1.5,
        "c - b, 1 sd of size": -0.5,
    }
    assert found["size"]["area"][0].effect == pytest.approx(sd * 6.5 / 3, abs=1e-3)
    means = size.mean() * np.array([2.0, 1.5, -0.5])
    np.testing.assert_allclose([f.effect[0] for f in found["line"]["area"]], means, atol=1e-3)


def test_family_wise_p_is_of_the_largest_anywhere():
    """All 120 orders of five shapes, by least squares, over the points of two kinds of operators."""
    S, size, age = RNG.normal(size=(5, 60)), RNG.uniform(size=5), RNG.uniform(size=5)
    found = fields({"area": S[:, :30], "conformal": S[:, 30:]}, "~ size + age", {"size": size, "age": age},
                   permutations=120)["size"]  # fmt: skip
    R, X = np.column_stack([np.ones(5), age]), np.column_stack([np.ones(5), age, size])
    fitted, largest = R @ np.linalg.lstsq(R, S, rcond=None)[0], []
    error = np.sqrt(np.linalg.inv(X.T @ X)[2, 2])

    def t(S):
        B, rest, _, _ = np.linalg.lstsq(X, S, rcond=None)
        return np.abs(B[2]) / np.sqrt(rest / 2) / error

    for order in permutations(range(5)):
        largest.append(t(fitted + (S - fitted)[list(order)]).max())
    expected = (np.array(largest)[:, None] >= t(S) - 1e-9).mean(0)
    np.testing.assert_allclose(np.concatenate([found["area"][0].p, found["conformal"][0].p]), expected)


def test_a_place_is_found_and_elsewhere_nothing_is_left():
    group = np.array(list("ab") * 10)
    S = RNG.normal(size=(20, 30))
    S[:, :5] += 3 * (group == "b")[:, None]
    found = fields({"area": S}, "~ group", {"group": group})["group"]["area"][0]
    assert found.significant.nonzero()[0].tolist() == list(range(5))
    assert (found.least[:5] > 0).all()
    assert (found.least[:5] < found.effect[:5]).all()
    assert not found.least[5:].any()
    assert found.false[:5].max() < 0.01 < 0.2 < found.false[5:].min()
    assert np.count_nonzero(found.shrunk[5:]) <= 1
    assert (found.shrunk[:5] > 0.5 * found.effect[:5]).all()


def test_pairs_by_themselves():
    person, state = np.repeat(np.arange(8), 2), np.array(["before", "after"] * 8)
    S = 9 * RNG.normal(size=(8, 30))[person] + RNG.normal(size=(16, 30))
    found = fields({"area": S}, "~ state", {"state": state}, person)["state"]["area"][0]
    known = stats.ttest_rel(S[::2], S[1::2])
    np.testing.assert_allclose(found.statistic, known.statistic, rtol=1e-9)


def test_sizes_of_shapes_that_are_larger_everywhere(meshes):
    """All local areas are larger by a third."""
    latent = LatentSpace.fit(MapNetwork.clique([eigenbasis(mesh, 20) for mesh in meshes[:4]]), 16, 10)
    D = stack_differences(latent, ["area", "conformal"])
    one = local_sizes(latent, D[:, 0], 1)
    assert one.shape == (4, len(latent.eigenbasis(1).mass))
    np.testing.assert_allclose(local_sizes(latent, D[:, 0] * 4 / 3, 1) - one, np.log(4 / 3), rtol=1e-9)
    live = torch.arange(10) > 0
    assert np.isfinite(local_sizes(latent, D[:, 1], 0, live)).all()


def test_enhanced_by_thresholds_one_by_one():
    """Runs of the same sign on a line, at each threshold, by walking along it."""
    t = np.round(3 * RNG.normal(size=(2, 30)), 2)
    found, expected = enhanced(t, CELLS), np.zeros((2, 30))
    for row in range(2):
        for h in 0.25 * np.arange(1, 41):
            for sign in (1, -1):
                above, first = np.r_[sign * t[row] >= h, False], 0
                for i in range(31):
                    if not above[i]:
                        expected[row, first:i] += h**2 * 0.25 * CELLS.area[first:i].sum() * (i > first)
                        first = i + 1
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_more_of_what_is_wide_and_weak_is_found_by_enhancement():
    group, rng = np.array(list("ab") * 10), np.random.default_rng(5)
    S = rng.normal(size=(20, 30))
    S[:, 8:20] += 0.9 * (group == "b")[:, None]
    wide = fields({"area": S}, "~ group", {"group": group})["group"]["area"][0]
    assert (wide.p_enhanced[8:20] <= 0.05).mean() > (wide.p[8:20] <= 0.05).mean()


def test_fields_and_the_question_whether_anything_is_anywhere_agree():
    S, group = RNG.normal(size=(12, 60)), np.array(list("ab") * 6, dtype=object)
    sizes = {"area": S[:, :30], "conformal": S[:, 30:]}
    made = design("~ group", {"group": group}, [str(i) for i in range(12)])
    (part,) = strata(made, None, "", 199, 0)
    chances = anywhere(sizes, made, made.terms[0], part, CELLS).values()
    found = [of[0] for of in term_fields(sizes, made, made.terms[0], part, MASS, CELLS).values()]
    for w, name in enumerate(("p", "p_enhanced")):
        largest = Chance(np.max([chance[w].found for chance in chances], axis=0), part.exact)
        assert min(getattr(field, name).min() for field in found) == largest.p


def test_cells_of_a_surface(meshes):
    cells = Cells.of(meshes[0], 40)
    assert cells.area.sum() == pytest.approx(1)
    assert 0.9 * (3 * 40 - 6) < len(cells.borders) <= 3 * 40 - 6  # fewer where four cells meet in a point
    np.testing.assert_allclose(cells.carry @ np.ones(40), 1)
