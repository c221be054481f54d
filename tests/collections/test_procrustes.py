import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.collections import ShapeList
from lssd_learn.collections.procrustes import centred_vertices, procrustes
from lssd_learn.shapes import Mesh

TRAIN = np.array([0, 2, 3, 7])


@pytest.fixture(scope="module")
def spheres(deformed_spheres):
    """Eight deformed spheres, one connectivity."""
    return deformed_spheres(8, 2)


def moved(shapes, seed=1):
    """Each shape turned and shifted in a way of its own."""
    generator = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(3 * generator.normal(size=(len(shapes), 3))).as_matrix()
    return [
        Mesh(shape.vertices @ turn + generator.normal(size=3), shape.faces)
        for turn, shape in zip(turns, shapes, strict=True)
    ]


def aligned(shapes, train=TRAIN):
    vertices = centred_vertices(ShapeList(shapes))
    return vertices @ procrustes(vertices, train)


def test_vertices_are_centred_before_they_are_rounded(spheres):
    vertices = centred_vertices(ShapeList(spheres))
    assert (vertices.shape, vertices.dtype) == ((8, 162, 3), np.float32)
    np.testing.assert_allclose(vertices.mean(axis=1), 0, atol=1e-7)
    far = centred_vertices(ShapeList([Mesh(shape.vertices + 1e6, shape.faces) for shape in spheres]))
    np.testing.assert_allclose(far, vertices, atol=1e-6)


def test_copies_of_one_shape_come_to_lie_upon_each_other(spheres):
    shapes = aligned(moved([spheres[0]] * 8))
    np.testing.assert_allclose(shapes, np.broadcast_to(shapes[0], shapes.shape), atol=1e-5)


def test_rigid_motions_change_nothing_but_the_common_rotation(spheres):
    here, there = (aligned(shapes).reshape(8, -1) for shapes in (spheres, moved(spheres)))
    np.testing.assert_allclose(there @ there.T, here @ here.T, atol=2e-4 * (here @ here.T).max())


def test_rotations_are_rotations_and_a_mirror_image_is_not_reflected(spheres):
    mirror = Mesh(spheres[0].vertices * [-1, 1, 1], spheres[0].faces)
    vertices = centred_vertices(ShapeList([*spheres, mirror]))
    rotations = procrustes(vertices, TRAIN)
    np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1), np.tile(np.eye(3), (9, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(rotations), 1)


def test_no_shape_can_be_turned_nearer_to_the_mean(spheres):
    shapes = aligned(spheres).astype(float)
    mean = shapes[TRAIN].mean(axis=0)
    for shape in shapes:
        best = np.linalg.norm(shape - mean)
        for turn in Rotation.from_rotvec(0.05 * np.random.default_rng(0).normal(size=(20, 3))).as_matrix():
            assert np.linalg.norm(shape @ turn - mean) > best


def test_other_shapes_have_no_part_in_the_mean(spheres):
    other = moved(spheres)
    mixed = [shape if i in TRAIN else other[i] for i, shape in enumerate(spheres)]
    assert np.array_equal(aligned(mixed)[TRAIN], aligned(spheres)[TRAIN])
