import pickle

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf
from scipy.spatial import cKDTree

from lssd_learn.app import conf
from lssd_learn.collections import POSE_NAMES, Bodies, Characters
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"
TWO = {"slim": {"weight": 0.1}, "heavy": {"weight": 0.9, "belly": 0.9}}


@pytest.fixture(scope="module")
def two():
    return Characters(TWO, ("rest", "sitting"), topology=SMALL)


@pytest.fixture(scope="module")
def clouds():
    return Characters(TWO, ("rest", "sitting"), topology=SMALL, points=400)


def test_each_in_the_same_poses(two):
    assert two.names == ["slim_rest", "slim_sitting", "heavy_rest", "heavy_sitting"]
    assert two.groups["character"].tolist() == ["slim", "slim", "heavy", "heavy"]
    assert two.groups["pose"].tolist() == ["rest", "sitting"] * 2
    made = Bodies(1, topology=SMALL).make({"weight": 0.9, "belly": 0.9}, "sitting")
    np.testing.assert_array_equal(two[3].vertices, made.vertices)
    assert two[3].area > two[1].area
    assert len({shape.connectivity for shape in two}) == 1
    assert set(two.parts) >= {"head", "torso"}


def test_random_ones_are_those_of_the_bodies():
    people, bodies = Characters(3, seed=5, topology=SMALL), Bodies(3, seed=5, topology=SMALL)
    assert people.names[8:10] == ["character_01_rest", "character_01_arms_down"]
    np.testing.assert_array_equal(people.parameters[::8], bodies.parameters)
    np.testing.assert_array_equal(people[9].vertices, bodies[1].vertices)


def test_clouds_lie_on_the_meshes_and_are_no_two_alike(two, clouds):
    for cloud, mesh in zip(clouds, two, strict=True):
        assert cloud.points.shape == (400, 3)
        assert cKDTree(mesh.vertices).query(cloud.points)[0].max() < 0.15
    assert cKDTree(clouds[0].points).query(clouds[2].points)[0].min() > 0
    assert [clouds.meshes.shape_key(i) for i in range(4)] == [two.shape_key(i) for i in range(4)]
    np.testing.assert_array_equal(clouds.meshes[2].vertices, two[2].vertices)
    assert clouds.parts == {}


def test_landmarks_are_the_same_places_on_all(two, clouds):
    assert list(two.landmarks[0]) == [f"landmark_{i:02d}" for i in range(10)]
    assert two.landmarks[0] == two.landmarks[3]
    for mesh, cloud, here, there in zip(two, clouds, two.landmarks, clouds.landmarks, strict=True):
        distances = np.linalg.norm(mesh.vertices[list(here.values())] - cloud.points[list(there.values())], axis=1)
        assert distances.max() < 0.15
    assert Characters(TWO, topology=SMALL, landmarks=0).landmarks == []


def test_keys_hold_all_that_makes_a_shape(two, clouds):
    others = [clouds, Characters(TWO, ("sitting", "rest"), topology=SMALL), Characters(TWO, topology=SMALL),
              Characters(TWO, ("rest", "sitting"), topology=SMALL, landmarks=5)]  # fmt: skip
    assert len({two.key, *(other.key for other in others)}) == 5
    assert two.shape_key(1) == others[1].shape_key(0) == others[3].shape_key(1) != two.shape_key(0)
    same = pickle.loads(pickle.dumps(clouds))
    np.testing.assert_array_equal(same[-1].points, clouds[3].points)
    with pytest.raises(IndexError):
        two[4]


def test_the_configuration_is_the_default():
    made = instantiate(OmegaConf.load(conf() / "collection" / "characters.yaml"))
    assert (made.key, len(made)) == (Characters().key, 2 * len(POSE_NAMES))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"characters": 0}, "characters=0: expected a whole number, 1 or more"),
        ({"characters": {}}, "characters: expected at least one, got none"),
        ({"characters": {"a": {"wiegth": 1}}}, "characters: a has 'wiegth', expected some of muscle, weight"),
        ({"characters": {"a": {"weight": 2}}}, r"characters: expected weight of a in \[0, 1\], got 2"),
        ({"poses": ["flying"]}, "pose: expected one of rest"),
        ({"poses": ["rest", "rest"]}, "poses: expected one or more, each once, got rest, rest"),
        ({"poses": []}, "got none"),
        ({"points": 10}, "points=10: expected a whole number, 100 or more"),
        ({"landmarks": -1}, "landmarks=-1: expected a whole number, 0 to 100"),
        ({"seed": -1}, "seed: expected a whole number"),
        ({"topology": "cube"}, "topology: expected one of notoes"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        Characters(**arguments)
