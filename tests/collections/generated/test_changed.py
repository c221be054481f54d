import numpy as np
import pytest

from lssd_learn.collections import Bodies, Changed
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.errors import InputError

SMALL = {"topology": "notoes_collapse5pc"}


@pytest.mark.parametrize("others", ["middle", "matched", "random"])
def test_the_groups_differ_in_one_parameter(others):
    bodies = Changed("thigh", n=9, low=0.2, high=0.9, others=others, **SMALL)
    small, large = bodies.parameters[:9], bodies.parameters[9:]
    thigh = bodies.parameter_names.index("thigh")
    assert set(small[:, thigh]) == {0.2}
    assert set(large[:, thigh]) == {0.9}
    rest = np.delete(small, thigh, axis=1)
    assert (rest == 0.5).all() == (others == "middle")
    assert np.array_equal(rest, np.delete(large, thigh, axis=1)) == (others != "random")
    assert bodies.groups["size"].tolist() == ["small"] * 9 + ["large"] * 9
    assert bodies.groups["pose"].tolist() == [*POSE_NAMES, "rest"] * 2
    assert len(set(bodies.names)) == len(bodies) == 18


def test_bodies_stand_as_they_are_made():
    changed, bodies = Changed("waist", others="random", seed=3, **SMALL), Bodies(1, **SMALL)
    np.testing.assert_array_equal(changed[11].vertices, bodies.make(changed.parameters[11], "sitting").vertices)
    np.testing.assert_array_equal(changed[-5].vertices, changed[11].vertices)


def test_the_truth_is_where_the_parameter_acts():
    bodies = Changed("calf", **SMALL)
    ratio = bodies.log_area_ratio
    np.testing.assert_allclose(ratio, np.log(bodies[8].vertex_areas / bodies[0].vertex_areas), atol=1e-12)
    height = bodies[0].vertices[:, 2]
    calf = np.abs(ratio) > 0.5 * np.abs(ratio).max()
    part = (height[calf] - height.min()) / np.ptp(height)
    assert part.min() > 0.05
    assert part.max() < 0.3
    np.testing.assert_allclose(Changed("calf", low=1, high=0.5, **SMALL).log_area_ratio, -ratio, atol=1e-12)


def test_a_body_is_known_by_what_it_is():
    waist, calf = Changed("waist", **SMALL), Changed("calf", **SMALL)
    assert waist.shape_key(0) == calf.shape_key(0)
    assert len({waist.shape_key(i) for i in range(16)} | {calf.shape_key(8)}) == 17
    assert waist.key != calf.key


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"change": "nose"}, "change=nose: expected one of muscle, weight"),
        ({"n": 1}, "n=1: expected a whole number, 2 or more"),
        ({"low": -0.1}, r"low=-0.1: expected a number in \[0, 1\]"),
        ({"high": "much"}, r"high=much: expected a number in \[0, 1\]"),
        ({"low": 1}, "high=1.0: expected another value than low"),
        ({"others": "same"}, "others=same: expected one of middle, matched, random"),
    ],
)
def test_mistakes(arguments, message):
    with pytest.raises(InputError, match=message):
        Changed(**arguments)
