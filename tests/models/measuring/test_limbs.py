import numpy as np
import pytest

from lssd_learn.collections.generated.body.poses import bone_rotations
from lssd_learn.collections.generated.skinned import BONES, LOOSE, some_turns
from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.laying import FEW, Layer
from lssd_learn.models.measuring.limbs import about_face, apart, limbs, rearranged
from lssd_learn.models.measuring.posable import Pose
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.sampling import farthest_points, sample

ARMS_UP = {"upperarm01.L": (0, -110, 0), "upperarm01.R": (0, 110, 0)}


def held(figure, angles):
    turns = np.tile(np.eye(3), (len(BONES), 1, 1))
    for bone, turn in bone_rotations(angles).items():
        turns[BONES.index(bone)] = turn
    return Pose(np.zeros(12), turns, np.zeros(3))


@pytest.fixture(scope="module")
def few(figure):
    return figure.body.some(farthest_points(figure.body.mean.sum(axis=1), FEW))


@pytest.fixture(scope="module")
def raised(figure):
    return Mesh(figure.body.lying(held(figure, ARMS_UP)).points, figure.body.faces)


def test_limbs_are_arms_and_legs(figure):
    found = [[BONES[joint].split(".")[0] for joint in limb] for limb in limbs(figure.body)]
    arm, leg = ["clavicle", "upperarm01", "lowerarm01", "wrist"], ["upperleg01", "lowerleg01", "foot"]
    assert found == [arm, arm, leg, leg]


def test_an_arm_that_hangs_is_raised_as_that_of_the_scan(few, figure, raised):
    surface = sample(raised, 3000, np.random.default_rng(0))
    tree = cKDTree(surface)
    hanging = held(figure, {"upperarm01.L": ARMS_UP["upperarm01.L"], "upperarm01.R": (0, -35, 0)})
    found = rearranged(few, hanging, some_turns(60, 10, 0)[1::2], surface, tree)
    before, after = (apart(few.lying(pose).points, surface, tree, 0.3) for pose in (hanging, found))
    assert after < before / 2
    wanted, before, after = (
        figure.body.lying(pose).at[BONES.index("wrist.R")] for pose in (held(figure, ARMS_UP), hanging, found)
    )
    assert np.linalg.norm(after - wanted) < 0.3 * np.linalg.norm(before - wanted)
    np.testing.assert_array_equal(found.turns[BONES.index("upperleg01.L")], np.eye(3))


def test_about_face_is_where_it_stood_and_twice_is_none(few, figure):
    pose = held(figure, {"spine03": (40, 0, 0)})
    other = about_face(few, pose)
    there, before = few.lying(other).points, few.lying(pose).points
    np.testing.assert_allclose(there.mean(axis=0), before.mean(axis=0))
    assert np.linalg.norm(there - before, axis=1).mean() > 0.1
    np.testing.assert_allclose(few.lying(about_face(few, other)).points, before, atol=1e-12)


def test_arms_above_the_head_are_found(figure, raised):
    drawn = np.random.default_rng(0).normal(size=(60, 6))
    fit = Layer(figure, LOOSE, drawn, some_turns(60, 10, 0)).lay(raised)
    assert fit.off < 1e-3
    assert fit.missing == fit.extra == 0
