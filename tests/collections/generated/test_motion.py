import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.collections import Bodies, Motion
from lssd_learn.collections.generated.motions import MOTIONS, angles
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"


@pytest.fixture(scope="module")
def motion():
    """One character, every motion in 16 frames."""
    return Motion(1, frames=16, topology=SMALL)


@pytest.fixture(scope="module")
def vertices(motion):
    """Motion → (16, 615, 3)."""
    frames = np.stack([mesh.vertices for mesh in motion])
    return {name: frames[motion.groups["motion"] == name] for name in MOTIONS}


def test_what_is_known_is_known_without_the_body_model():
    code = (
        "import sys; from lssd_learn.collections import Motion; m = Motion(); "
        "assert len(m) == len(set(m.names)) == 2560, len(m); m.key, m.shape_key(3), m.up, m.groups; "
        "assert not {'anny', 'torch'} & set(sys.modules), 'loaded'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    motion = Motion(3, frames=5)
    assert motion.names[0] == "character00_walk_000"
    assert motion.names[-1] == "character02_squat_004"
    for i, name in enumerate(motion.names):
        assert name == f"{motion.groups['character'][i]}_{motion.groups['motion'][i]}_{i % 5:03d}"
    np.testing.assert_array_equal(motion.parameters[::20], Bodies(3).parameters)
    np.testing.assert_array_equal(motion.parameters[:20], motion.parameters[[0] * 20])


def test_a_shape_does_not_depend_on_how_many_there_are():
    few, many = Motion(2, ["squat"], 8), Motion(3, frames=16)
    at = [many.names.index(f"character01_squat_{2 * f:03d}") for f in range(8)]
    assert [few.shape_key(8 + f) for f in range(8)] == [many.shape_key(i) for i in at]
    assert few.key != many.key
    keys = [many.shape_key(i) for i in range(len(many))]
    assert len(set(keys)) == len(many)
    assert Motion(2, ["squat"], 8, seed=1).shape_key(0) != few.shape_key(0)
    assert Motion(2, ["squat"], 8, topology=SMALL).shape_key(0) != few.shape_key(0)


def test_standing_on_the_ground_in_one_connectivity(motion, vertices):
    bodies = Bodies(1, topology=SMALL)
    assert motion[20].connectivity == bodies[0].connectivity
    assert set(motion.parts) == set(bodies.parts)
    for frames in vertices.values():
        np.testing.assert_allclose(frames[:, :, 2].min(1), 0, atol=1e-12)
        assert (np.ptp(frames[:, :, 2], axis=1) > 0.8).all()
    np.testing.assert_array_equal(motion[-1].vertices, vertices["squat"][-1])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(motion))[3].vertices, vertices["walk"][3])


def test_frames_follow_each_other_and_none_comes_twice(vertices):
    frames = np.concatenate(list(vertices.values()))
    apart = np.linalg.norm(frames[:, None] - frames, axis=-1).mean(-1)
    assert apart[~np.eye(len(frames), dtype=bool)].min() > 0.003
    for some in vertices.values():
        steps = np.linalg.norm(some - np.roll(some, 1, axis=0), axis=-1)
        assert steps.max() < 0.4  # the tip of an arm
        assert steps.mean(1).max() < 4 * steps.mean()


def test_a_character_moves_nearly_isometrically(motion, vertices):
    faces = motion[0].faces
    frames = np.concatenate(list(vertices.values()))
    lengths = np.linalg.norm(frames[:, faces] - frames[:, np.roll(faces, 1, axis=1)], axis=-1)
    assert np.median(np.abs(np.log(lengths / lengths[0]))) < 0.02
    assert np.median(np.abs(frames - frames[0])) > 0.02


@pytest.mark.parametrize("name", MOTIONS)
@given(moment=st.floats(0, 1))
@settings(max_examples=25, deadline=None)
def test_angles_stay_between_their_keys_and_come_round(name, moment):
    for bone, xyz in angles(name, moment).items():
        keys = np.array(list(MOTIONS[name][bone].values()))
        assert (xyz >= keys.min(0) - 1e-9).all()
        assert (xyz <= keys.max(0) + 1e-9).all()
    later = angles(name, moment + 1)
    for bone, xyz in angles(name, moment).items():
        np.testing.assert_allclose(later[bone], xyz, atol=1e-6)


@given(moment=st.floats(0, 1))
@settings(max_examples=25, deadline=None)
def test_walking_does_on_the_right_what_it_did_on_the_left(moment):
    before, after = angles("walk", moment), angles("walk", moment + 0.5)
    for bone, xyz in before.items():
        other = after[bone.replace(".L", ".R") if ".L" in bone else bone.replace(".R", ".L")]
        np.testing.assert_allclose(np.array(xyz) * [1, -1, -1], other, atol=1e-6)


def test_squatting_bends_hips_knees_and_ankles_and_sinks(vertices):
    standing, low = angles("squat", 0), angles("squat", 0.45)
    for bone, degrees in (("upperleg01", -90), ("lowerleg01", 90), ("foot", -20)):
        for side in (".L", ".R"):
            assert (low[bone + side][0] - standing[bone + side][0]) / degrees > 1
    heights = np.ptp(vertices["squat"][:, :, 2], axis=1)
    assert heights[7] < 0.8 * heights[0]


def test_arms_rise_over_the_head_and_a_knee_over_the_other(motion, vertices):
    head = motion.parts["head"]
    raised, hanging = vertices["arm_raise"][8], vertices["arm_raise"][0]
    for arm in ("left_arm", "right_arm"):
        assert raised[motion.parts[arm]][:, 2].max() > raised[head][:, 2].max()
        assert hanging[motion.parts[arm]][:, 2].min() < 0.6 * hanging[:, 2].max()
    knee_up = vertices["knee_lean"][8]
    left, right = (knee_up[motion.parts[leg]][:, 2].min() for leg in ("left_leg", "right_leg"))
    assert right > left + 0.08
    lean = knee_up[head].mean(0) - vertices["knee_lean"][0][head].mean(0)
    assert lean[0] > 0.1  # to its left


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"characters": 0}, "characters"),
        ({"frames": 2.5}, "frames"),
        ({"motions": ["fly"]}, "motions: expected some of walk, arm_raise, knee_lean, squat"),
        ({"motions": ["walk", "walk"]}, "each once"),
        ({"motions": []}, "motions"),
        ({"topology": "smpl"}, "topology"),
        ({"seed": -1}, "seed"),
    ],
)
def test_arguments_out_of_range(arguments, message):
    with pytest.raises(InputError, match=message):
        Motion(**arguments)


def test_poses_of_ones_own():
    bodies = Bodies(1, topology=SMALL)
    own = bodies.make({}, {"upperleg01.L": (-70, 0, 0), "lowerleg01.L": (70, 0, 0)})
    np.testing.assert_array_equal(own.vertices, bodies.make({}, "knee_up").vertices)
    with pytest.raises(InputError, match="pose: expected bones of the body model, such as pelvis.L, got 'wing'"):
        bodies.make({}, {"wing": (0, 0, 0)})
    with pytest.raises(InputError, match="expected three angles for root"):
        bodies.make({}, {"root": (0, 0)})
    with pytest.raises(InputError, match="motion: expected some of walk"):
        angles("fly", 0)
