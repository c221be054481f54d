import pickle

import numpy as np
import pytest

from lssd_learn.collections import Bodies, Mixed
from lssd_learn.collections.generated.body.poses import POSES
from lssd_learn.collections.generated.mixed import MIXED_POSES, half_pose, mixed_pose, named_pose
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"


def test_every_combination_of_halves_once():
    assert len(MIXED_POSES) == 24
    angles = [mixed_pose(*halves) for halves in MIXED_POSES]
    assert not any(angles[i] == angles[j] for i in range(24) for j in range(i))
    for lower in POSES:
        for upper in POSES:
            assert mixed_pose(lower, upper) in angles
    for pose, whole in POSES.items():
        assert half_pose(pose, "upper_body") | half_pose(pose, "lower_body") == whole == named_pose(pose)
    assert named_pose("sitting+t_pose") == mixed_pose("sitting", "t_pose")


def test_what_is_known():
    mixed = Mixed(30, seed=2)
    assert mixed.names == Bodies(30, seed=2).names
    np.testing.assert_array_equal(mixed.parameters, Bodies(30, seed=2).parameters)
    assert mixed.groups["pose"][26] == mixed.groups["pose"][2] == "rest+t_pose"
    keys = [mixed.shape_key(i) for i in range(30)]
    assert len(set(keys)) == 30
    assert keys[:5] == [Mixed(5, seed=2).shape_key(i) for i in range(5)]
    assert len({Mixed(5, seed=2).key, mixed.key, Mixed(5, seed=3).key, Mixed(5, topology=SMALL).key}) == 4
    with pytest.raises(InputError, match="topology"):
        Mixed(topology="smpl")


def test_each_half_stands_as_in_its_own_pose():
    mixed = Mixed(12, topology=SMALL)
    i = MIXED_POSES.index(("sitting", "reach"))
    body = mixed[i].vertices
    np.testing.assert_array_equal(body, pickle.loads(pickle.dumps(mixed))[i - 12].vertices)
    sitting, reach = (mixed.bodies.make(mixed.parameters[i], pose).vertices for pose in ("sitting", "reach"))
    arms = mixed.parts["left_arm"] | mixed.parts["right_arm"]
    legs = mixed.parts["left_leg"] | mixed.parts["right_leg"]
    np.testing.assert_allclose(body[arms], reach[arms], atol=0.005)
    np.testing.assert_allclose(body[legs], sitting[legs], atol=0.005)
    assert np.linalg.norm(body - sitting, axis=1)[arms].mean() > 0.1
    assert np.linalg.norm(body - reach, axis=1)[legs].mean() > 0.1
    with pytest.raises(IndexError):
        mixed[12]
