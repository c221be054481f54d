"""Shape along a number, and shapes without it."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.exploration.models.allometry import regression_scores, without
from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.vectors import model_vectors
from lssd_learn.operators.logarithms import exponential

RNG = np.random.default_rng(3)
SIZE, SEX = RNG.uniform(1, 2, 14), np.array(list("mf") * 7, dtype=object)
SLOPES = torch.from_numpy(RNG.normal(size=(2, 4, 4)))
SLOPES = SLOPES + SLOPES.mT


def operators(noise=0.0):
    own = torch.from_numpy(RNG.normal(size=(14, 4, 4))) * noise
    slope = SLOPES[(SEX == "m").astype(int)]
    return exponential(0.3 * torch.from_numpy(SIZE)[:, None, None] * slope + own + own.mT)


def test_with_a_slope_a_group_nothing_is_left_but_the_groups():
    D = operators()
    made = design("~ size * sex", {"size": SIZE, "sex": SEX}, [""] * 14)
    left = without(D, made, "size")
    for sex in "mf":
        some = left[torch.from_numpy(sex == SEX)]
        torch.testing.assert_close(some, some[:1].expand_as(some))
    at_mean = exponential(0.3 * SIZE.mean() * SLOPES[1])
    torch.testing.assert_close(left[0], at_mean)


def test_taken_out_once_nothing_more_is_there():
    made = design("~ log(size) + sex", {"size": SIZE, "sex": SEX}, [""] * 14)
    left = without(operators(0.1), made, "log(size)")
    torch.testing.assert_close(without(left, made, "log(size)"), left)
    with pytest.raises(InputError, match=r"task.without=sex: expected a number of the formula, it has log\(size\)"):
        without(left, made, "sex")


def test_scores_follow_the_number():
    made = design("~ size", {"size": SIZE}, [""] * 14)
    slope = torch.from_numpy(SIZE)[:, None, None] * SLOPES[0] + 0.1 * torch.from_numpy(RNG.normal(size=(14, 4, 4)))
    scores = regression_scores(model_vectors(exponential(slope + slope.mT)[:, None], ["area"])["area"], made)
    assert np.corrcoef(scores["size"], SIZE)[0, 1] > 0.95


def test_vectors_have_the_inner_products_of_logarithms_and_kinds_count_the_same():
    D = torch.stack([operators(0.1), operators(0.3)], dim=1)
    D[:, 1, 0, :] = D[:, 1, :, 0] = 0  # a null function
    found = model_vectors(D, ["area", "conformal"])
    logs = torch.stack([torch.linalg.eigh(one)[1] @ torch.diag(torch.linalg.eigh(one)[0].log()) @
                        torch.linalg.eigh(one)[1].T for one in D[:, 0]]).flatten(1)  # fmt: skip
    logs = (logs - logs.mean(0)).numpy()
    np.testing.assert_allclose(found["area"] @ found["area"].T, logs @ logs.T, atol=1e-9)
    both = found["area+conformal"]
    parts = sum(Y @ Y.T / np.square(Y).sum() for Y in (found["area"], found["conformal"]))
    np.testing.assert_allclose(both @ both.T, parts, atol=1e-9)
