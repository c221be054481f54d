"""Partial analogies with a known answer."""

import numpy as np
import pytest

from lssd_learn.collections import Bodies
from lssd_learn.collections.generated.body.poses import POSES
from lssd_learn.collections.generated.mixed import half_pose
from lssd_learn.errors import InputError
from lssd_learn.measures.mixtures import ROLES, SLIDERS, Mixture, draw_mixtures

SMALL = "notoes_collapse5pc"


def test_the_truth_has_the_sliders_and_bones_of_B_on_the_region_and_those_of_A_elsewhere():
    bodies = Bodies(4, topology=SMALL)
    names = list(bodies.parameter_names)
    mixture = Mixture("both", 1, 2, "sitting", "t_pose")
    for region, pose in (("upper_body", "sitting+t_pose"), ("lower_body", "t_pose+sitting")):
        A, B, truth = mixture.shapes(bodies, region)
        for slider in ("muscle", "weight", "height"):
            assert len({made.parameters[0, names.index(slider)] for made in (A, B, truth)}) == 1
        for half, sliders in SLIDERS.items():
            for slider in sliders:
                a, b, t = (made.parameters[0, names.index(slider)] for made in (A, B, truth))
                assert (a, b) == tuple(bodies.parameters[[1, 2], names.index(slider)])
                assert t == (b if half == region else a)
        lower, upper = pose.split("+")
        assert truth.pose == half_pose(lower, "lower_body") | half_pose(upper, "upper_body") == mixture.pose(region)
        np.testing.assert_array_equal(A[0].vertices, bodies.make(bodies.parameters[1], "sitting").vertices)
        assert len({made.key for made in (A, B, truth)}) == 3
        assert len({made.names[0] for made in (A, B, truth)}) == 3


def test_local_sliders_act_on_their_half():
    bodies = Bodies(1, topology=SMALL)
    faces, mask = bodies.make({}).faces, bodies.parts["upper_body"]
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])

    def lengths(**parameters):
        x = bodies.make(parameters).vertices
        return np.linalg.norm(x[ends[:, 0]] - x[ends[:, 1]], axis=1)

    rest = lengths()
    for half, sliders in SLIDERS.items():
        for slider in sliders:
            change = (rest * np.log(lengths(**{slider: 1.0}) / lengths(**{slider: 0.0}))) ** 2
            inside, outside = (side[ends].all(1) for side in (mask, ~mask))
            both = change[inside].sum(), change[outside].sum()
            mine, other = both if half == "upper_body" else both[::-1]
            assert mine > 1.5 * other, slider


def test_pairs_differ_as_their_role_says():
    found = draw_mixtures(range(2, 6), 20, np.random.default_rng(0))
    assert len(set(found)) == len(found) == 60
    assert [mixture.role for mixture in found] == [role for role in ROLES for _ in range(20)]
    for mixture in found:
        assert {mixture.p, mixture.q} <= set(range(2, 6))
        assert (mixture.p == mixture.q) == (mixture.role == "pose")
        if mixture.role == "body":
            assert mixture.a == mixture.b
        else:
            for half in SLIDERS:
                assert half_pose(mixture.a, half) != half_pose(mixture.b, half)
    assert {mixture.a for mixture in found} == set(POSES)
    with pytest.raises(InputError, match="pairs=17: 2 bodies give 16 at most"):
        draw_mixtures(range(2), 17, np.random.default_rng(0))
