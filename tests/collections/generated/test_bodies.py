import pickle
import subprocess
import sys

import numpy as np
import pytest

from lssd_learn.collections import POSE_NAMES, Bodies
from lssd_learn.collections.generated.body.limits import LIMBS, NUMBERS, free_pose
from lssd_learn.collections.generated.body.poses import POSES, between
from lssd_learn.errors import InputError


def edges(faces):
    """Directed edges as pairs."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def volume(mesh):
    return np.einsum("fi,fi->", *(np.cross(*mesh.vertices[mesh.faces[:, :2].T]), mesh.vertices[mesh.faces[:, 2]])) / 6


def test_nothing_but_a_shape_loads_the_body_model():
    code = (
        "import sys; from lssd_learn.collections import Bodies; b = Bodies(n=9); "
        "len(b), b.names, b.parameters, b.groups, b.key, b.shape_key(3), b.up; "
        "assert not {'anny', 'torch', 'warp'} & set(sys.modules), 'loaded'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_loading_prints_nothing():
    """Nor warns, but for a temporary folder that warp leaves to the interpreter where it has to be built first."""
    code = "from lssd_learn.collections import Bodies; Bodies(n=1, topology='notoes_collapse5pc')[0]"
    quiet = ("-W", "error", "-W", "ignore::ResourceWarning")
    done = subprocess.run([sys.executable, *quiet, "-c", code], check=True, capture_output=True)
    assert (done.stdout, done.stderr) == (b"", b"")


def test_what_is_known(bodies):
    assert len(bodies) == 16
    assert bodies.names[:2] == ["body_0000", "body_0001"]
    assert len(set(bodies.names)) == 16
    assert bodies.parameters.shape == (16, 12)
    assert bodies.parameter_names[:3] == ["muscle", "weight", "height"]
    assert list(bodies.groups["pose"][:9]) == [*POSE_NAMES, "rest"]


def test_a_body_does_not_depend_on_how_many_there_are():
    few, many = Bodies(n=5, seed=2), Bodies(n=40, seed=2)
    np.testing.assert_array_equal(few.parameters, many.parameters[:5])
    assert few.names == many.names[:5]
    assert few.shape_key(4) == many.shape_key(4)
    assert few.key != many.key


def test_age_and_gender_come_last_and_change_no_other():
    fixed, varied = Bodies(n=7, seed=1), Bodies(n=7, seed=1, vary_age=True)
    assert varied.parameter_names == [*fixed.parameter_names, "age", "gender"]
    np.testing.assert_array_equal(fixed.parameters, varied.parameters[:, :12])
    np.testing.assert_array_equal(varied.parameters[:3], Bodies(n=3, seed=1, vary_age=True).parameters)


def test_parameters_are_uniform():
    p = Bodies(n=4000).parameters
    assert p.min() >= 0
    assert p.max() <= 1
    np.testing.assert_allclose(p.mean(0), 0.5, atol=0.03)
    np.testing.assert_allclose(np.corrcoef(p.T), np.eye(12), atol=0.08)


def test_the_key_tells_every_argument():
    keys = {
        Bodies(n=8).key,
        Bodies(n=9).key,
        Bodies(n=8, seed=1).key,
        Bodies(n=8, topology="notoes_collapse10pc").key,
        Bodies(n=8, vary_age=True).key,
        Bodies(n=8, jitter=15).key,
        Bodies(n=8, jitter=7.5).key,
        Bodies(n=8, normalise_area=True).key,
    }
    assert len(keys) == 8
    assert Bodies(n=8, jitter=0).key == Bodies(n=8).key
    assert Bodies(n=8, jitter=15).shape_key(0) != Bodies(n=8).shape_key(0)
    assert Bodies(n=8).key == Bodies(n=8).key
    assert Bodies(n=8).shape_key(0) != Bodies(n=8).shape_key(1)


@pytest.mark.parametrize("i", [0, 3, 5, 15])
def test_closed_connected_and_oriented_outward(bodies, i):
    mesh = bodies[i]
    assert (mesh.vertices.shape, mesh.faces.shape) == ((615, 3), (1226, 3))
    directed = edges(mesh.faces)
    assert len(np.unique(directed, axis=0)) == len(directed)  # each edge once in a direction …
    np.testing.assert_array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0))  # … and once back
    assert 615 - len(directed) // 2 + 1226 == 2  # a sphere, so one component too
    assert 0.02 < volume(mesh) < 0.3  # cubic metres
    assert mesh.connectivity == bodies[0].connectivity


def test_the_same_bits_however_asked(bodies):
    import torch

    mesh = bodies[5]
    again = Bodies(n=6, seed=3, topology=bodies.topology)[5]
    np.testing.assert_array_equal(mesh.vertices, again.vertices)
    np.testing.assert_array_equal(mesh.vertices, bodies.make(bodies.parameters[5], 5).vertices)
    named = dict(zip(bodies.parameter_names, bodies.parameters[5], strict=True))
    np.testing.assert_array_equal(mesh.vertices, bodies.make(named, "stride").vertices)
    np.testing.assert_array_equal(mesh.vertices, pickle.loads(pickle.dumps(bodies))[5].vertices)
    np.testing.assert_array_equal(mesh.vertices, bodies[5 - 16].vertices)
    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(threads % 2 + 1)
        np.testing.assert_array_equal(mesh.vertices, bodies[5].vertices)
    finally:
        torch.set_num_threads(threads)


def test_eight_poses_of_one_body_differ(bodies):
    posed = [bodies.make({}, pose).vertices for pose in POSE_NAMES]
    for i in range(8):
        for j in range(i):
            assert np.linalg.norm(posed[i] - posed[j], axis=1).max() > 0.2  # metres


def test_poses_do_what_they_say(bodies):
    body = {pose: bodies.make({}, pose).vertices for pose in POSE_NAMES}
    parts = bodies.parts
    hand = {side: body["rest"][:, 0] * sign > 0.5 for side, sign in (("left", 1), ("right", -1))}
    assert (hand["left"] <= parts["left_arm"]).all()
    height = {pose: np.ptp(v[:, 2]) for pose, v in body.items()}
    assert height["rest"] - height["sitting"] > 0.3
    assert body["reach"][hand["left"], 2].mean() > body["reach"][parts["head"], 2].mean()
    assert np.ptp(body["t_pose"][:, 0]) > np.ptp(body["rest"][:, 0]) > np.ptp(body["arms_down"][:, 0])
    assert body["bend"][parts["head"], 1].mean() < body["rest"][parts["head"], 1].mean() - 0.2  # forward is -y
    lifted = body["knee_up"][:, 2] - body["rest"][:, 2]
    assert lifted[parts["left_leg"]].max() > 0.2
    assert abs(lifted[parts["right_leg"]]).max() < 0.05


def test_unit_area_is_the_same_body_smaller(bodies):
    small = Bodies(n=9, topology=bodies.topology, normalise_area=True)
    plain = Bodies(n=9, topology=bodies.topology)
    assert small[2].area == pytest.approx(1)
    np.testing.assert_allclose(small[2].vertices * np.sqrt(plain[2].area), plain[2].vertices, atol=1e-12)
    assert small.make(plain.parameters[2], "t_pose").area == pytest.approx(1)
    np.testing.assert_array_equal(small.parameters, plain.parameters)


def test_jitter_turns_joints_and_changes_nothing_else(bodies):
    few, many = (Bodies(n=n, seed=3, topology=bodies.topology, jitter=15) for n in (9, 12))
    np.testing.assert_array_equal(few.parameters, bodies.parameters[:9])
    np.testing.assert_array_equal(few[8].vertices, many[8].vertices)
    assert few[0].connectivity == bodies[0].connectivity
    moved = [np.linalg.norm(few[i].vertices - bodies[i].vertices, axis=1) for i in range(9)]
    assert all(0.03 < distance.max() < 0.6 for distance in moved)  # metres, every pose, rest too
    assert abs(moved[0] - moved[8]).max() > 0.01  # the same pose, other angles
    np.testing.assert_array_equal(few.make(few.parameters[0]).vertices, bodies[0].vertices)


@pytest.mark.parametrize(
    ("name", "measure"),
    [("height", lambda m: np.ptp(m.vertices[:, 2])), ("weight", volume), ("belly", volume), ("waist", volume)],
)
def test_parameters_do_what_they_say(bodies, name, measure):
    low, middle, high = (measure(bodies.make({name: p})) for p in (0, 0.5, 1))
    assert low < middle < high


def test_age_makes_bodies_taller():
    bodies = Bodies(n=1, topology="notoes_collapse5pc", vary_age=True)
    child, grown = (np.ptp(bodies.make({"age": age}).vertices[:, 2]) for age in (0.3, 0.67))
    assert child + 0.2 < grown


def test_parts_cover_the_body_once(bodies):
    parts = bodies.parts
    limbs = [parts[name] for name in ("head", "torso", "left_arm", "right_arm", "left_leg", "right_leg")]
    assert (np.sum(limbs, axis=0) == 1).all()
    np.testing.assert_array_equal(parts["upper_body"], ~parts["lower_body"])
    x, _, z = bodies.make({}).vertices.T
    assert x[parts["left_arm"]].min() > 0 > x[parts["right_leg"]].max()
    assert z[parts["head"]].mean() > z[parts["torso"]].mean() > z[parts["left_leg"]].mean()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"topology": "sphere"}, r"topology: expected one of notoes, .*got 'sphere'"),
        ({"n": 0}, r"n: expected a whole number, 1 or more, got 0"),
        ({"n": 2.5}, r"n: expected a whole number"),
        ({"seed": -1}, r"seed: expected a whole number, 0 or more, got -1"),
        ({"jitter": -1}, r"jitter: expected degrees, 0 or more, got -1"),
        ({"jitter": float("nan")}, r"jitter: expected degrees"),
        ({"jitter": "much"}, r"jitter: expected degrees, 0 or more, got 'much'"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        Bodies(**arguments)


@pytest.mark.parametrize(
    ("parameters", "pose", "message"),
    [
        ({"weigth": 0.5}, 0, r"parameters: expected some of muscle.*got 'weigth'"),
        ([0.5] * 11, 0, r"parameters: expected 12 values, got an array of \(11,\)"),
        ([0.5] * 11 + [1.5], 0, r"parameters: expected upper_leg_length in \[0, 1\], got 1.5"),
        (["much"] * 12, 0, r"parameters: expected numbers, got \['much'"),
        ([float("nan")] * 12, 0, r"parameters: expected muscle in \[0, 1\], got nan"),
        ({}, "handstand", r"pose: expected one of rest, .*got 'handstand'"),
        ({}, 8, r"pose: expected one of .* or 0 to 7, got 8"),
    ],
)
def test_bad_bodies_of_ones_choice(bodies, parameters, pose, message):
    with pytest.raises(InputError, match=message):
        bodies.make(parameters, pose)


def test_past_the_end(bodies):
    with pytest.raises(IndexError):
        bodies[16]


def test_random_poses_and_several_scans_of_one_person():
    plain = Bodies(n=4, topology="notoes_collapse3pc")
    posed = Bodies(n=4, topology="notoes_collapse3pc", poses="random", scans=2)
    assert list(posed.groups) == ["person"]
    assert posed.groups["person"].tolist() == ["person_0000"] * 2 + ["person_0001"] * 2
    np.testing.assert_array_equal(posed.parameters, plain.parameters[[0, 0, 1, 1]])
    assert not np.allclose(posed[0].vertices, posed[1].vertices, atol=0.05)
    longer = Bodies(n=7, topology="notoes_collapse3pc", poses="random", scans=2)
    np.testing.assert_array_equal(longer[3].vertices, posed[3].vertices)
    assert longer.shape_key(3) == posed.shape_key(3) != plain.shape_key(3)
    assert Bodies(n=4, topology="notoes_collapse3pc", poses="eight", scans=1).key == plain.key
    with pytest.raises(InputError, match="poses: expected one of eight, random, free, eight_and_free, got 'any'"):
        Bodies(poses="any")
    with pytest.raises(InputError, match="scans: expected a whole number, 1 or more, got 0"):
        Bodies(scans=0)


def test_free_poses_stay_within_their_limits_and_beside_the_eight():
    numbers = np.linspace(0, 1, NUMBERS)
    for share, knee in ((1e-3, 0), (0.5, 50), (1, 100)):
        assert free_pose(np.full(NUMBERS, share))["lowerleg01.R"] == pytest.approx((knee, 0, 0), abs=0.2)
    mirrored = [np.array(free_pose(np.full(NUMBERS, 0.8))[f"{bone}.{side}"]) for bone in LIMBS for side in "LR"]
    for left, right in zip(mirrored[::2], mirrored[1::2], strict=True):
        np.testing.assert_allclose(left, right * [1, -1, -1], atol=1e-9)
    assert free_pose(numbers) == free_pose(numbers.tolist())

    mixed = Bodies(n=12, topology="notoes_collapse3pc", poses="eight_and_free")
    expected = [*POSE_NAMES[:3], "free", *POSE_NAMES[3:6], "free", *POSE_NAMES[6:], POSE_NAMES[0], "free"]
    assert mixed.groups["pose"].tolist() == expected
    assert mixed.pose(0) == "rest"
    assert mixed.pose(7) != mixed.pose(3)
    free = Bodies(n=4, topology="notoes_collapse3pc", poses="free")
    assert "pose" not in free.groups
    np.testing.assert_array_equal(free[3].vertices, mixed[3].vertices)  # which pose does not ask for the others
    assert len({free.shape_key(3), mixed.shape_key(3), Bodies(n=4, topology="notoes_collapse3pc").shape_key(3)}) == 3


@pytest.mark.slow
def test_free_poses_seldom_run_into_themselves():
    """Less than the eight do, whose arms hang at the hips of wide bodies."""
    free, eight = (
        [inside(body) for body in Bodies(n=12, topology="notoes_collapse3pc", poses=poses)]
        for poses in ("free", "eight")
    )
    assert np.mean(free) < np.mean(eight)
    assert np.mean(np.array(free) > 0.01) < 0.1


def inside(mesh):
    """The share of vertices that lie inside another part: by the solid angles of all faces but their own (Van Oosterom
    and Strackee 1983)."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)[:, None] - mesh.vertices[:, None]
    p, q, r = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    below = p * q * r + (a * b).sum(2) * r + (b * c).sum(2) * p + (c * a).sum(2) * q
    angles = 2 * np.arctan2((a * np.cross(b, c)).sum(2), below)
    angles[mesh.faces.T, np.arange(len(mesh.faces))] = 0
    return np.mean(angles.sum(1) > 1.02 * 4 * np.pi)


def test_between_two_poses():
    eighth = 1 / 8
    assert between(0, 3 * eighth, 1.0) == {bone: tuple(xyz) for bone, xyz in POSES["sitting"].items()}
    half = between(3 * eighth, 4 * eighth, 0.5)
    assert half["upperleg01.L"] == (-75, 0, 0)
    assert half["upperleg01.R"] == (-40, 0, 0)
