from dataclasses import replace

import numpy as np
import pytest

from lssd_learn.exploration.models.points import PointField
from lssd_learn.exploration.models.words import in_words

EFFECT = np.log([1.1, 1.05, 0.98, 1.5])
P = np.array([0.01, 0.05, 0.02, 0.06])
FIELD = PointField("sex", "m - f", EFFECT, *[EFFECT] * 3, P, *[EFFECT] * 4)
MASS = [1.0, 2.0, 1.0, 6.0]


@pytest.mark.parametrize(
    ("change", "kind", "said"),
    [
        ({}, "area", "m is larger than f by up to 10.0 % on 30 % of the area, smaller by up to 2.0 % on 10 %"),
        ({"effect": -EFFECT}, "conformal",
         "m is more than f by up to 2.0 % on 10 % of the area, less by up to 9.1 % on 30 %"),
        ({"title": "1 sd of age"}, "area",
         "with 1 sd of age more, shapes are larger by up to 10.0 % on 30 % of the area,"
         " smaller by up to 2.0 % on 10 %"),
        ({"title": "b - a, 1 sd of age", "effect": np.abs(EFFECT)}, "area",
         "with 1 sd of age more, b grows larger than a by up to 10.0 % on 40 % of the area"),
        ({"title": ""}, "area", "sex matters on 40 % of the area"),
        ({"p": P + 1}, "area", "m - f: nothing more than chance"),
    ],
)  # fmt: skip
def test_a_field_in_words(change, kind, said):
    assert in_words(kind, replace(FIELD, **change), MASS) == said
