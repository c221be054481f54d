import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.closest_points import angles, sampled
from lssd_learn.shapes.rigid import rigid

TURNS = Rotation.random(4, rng=np.random.default_rng(5)).as_matrix()
SHIFT = np.array([5.0, -2.0, 1.0])


def moved(mesh, turn, shift=SHIFT):
    """A mesh turned and shifted, its faces turned over where that mirrors it."""
    return Mesh(mesh.vertices @ turn + shift, mesh.faces if np.linalg.det(turn) > 0 else mesh.faces[:, ::-1])


@pytest.mark.parametrize("turn", TURNS)
def test_a_turned_copy_gives_its_turn_and_shift_back(small_mesh, turn):
    found = rigid(small_mesh, moved(small_mesh, turn)).best
    np.testing.assert_allclose(found.rotation, turn, atol=1e-3)
    np.testing.assert_allclose(found.shift, SHIFT, atol=1e-3)
    assert not found.mirrored
    assert found.residual < 1e-3
    assert found.scale == pytest.approx(1, abs=1e-3)


def test_a_mirrored_copy_is_told(small_mesh):
    turn = TURNS[0] @ np.diag([1, 1, -1.0])
    found = rigid(small_mesh, moved(small_mesh, turn))
    assert found.best.mirrored
    assert angles(found.best.rotation.T @ turn) < 0.5  # its faces are turned over, and sampled elsewhere
    assert found.other.residual > 5 * max(found.best.residual, 1e-3)
    assert found.ties == []
    forbidden = rigid(small_mesh, moved(small_mesh, turn), mirror="forbid")
    assert not forbidden.best.mirrored
    assert forbidden.other is None
    assert forbidden.best.residual == pytest.approx(found.other.residual)


def test_other_vertices_and_another_size_change_little(small_mesh):
    finer = moved(_subdivided(small_mesh), TURNS[1], 0)
    found = rigid(small_mesh, Mesh(2 * finer.vertices, finer.faces)).best
    assert angles(found.rotation.T @ TURNS[1]) < 1
    assert found.scale == pytest.approx(2, rel=0.01)
    assert found.residual < 0.01


def test_a_mesh_that_is_inside_out_lies_as_it_lies(small_mesh):
    inside_out = Mesh(small_mesh.vertices @ TURNS[2], small_mesh.faces[:, ::-1])
    assert angles(rigid(small_mesh, inside_out).best.rotation.T @ TURNS[2]) < 0.5


def test_clouds(small_mesh):
    cloud = PointCloud(small_mesh.vertices)
    found = rigid(cloud, PointCloud(cloud.points @ TURNS[3] + SHIFT))
    np.testing.assert_allclose(found.best.rotation, TURNS[3], atol=1e-3)
    assert not found.ties
    with_mesh = rigid(cloud, moved(small_mesh, TURNS[3])).best
    assert angles(with_mesh.rotation.T @ TURNS[3]) < 1


def test_a_sphere_is_a_tie_and_says_so(sphere):
    assert set(rigid(sphere, moved(sphere, TURNS[0])).ties) == {"side", "turn"}


def test_a_shape_that_is_its_own_mirror_image_ties_in_the_side_and_stays_on_its_own(small_mesh):
    x = small_mesh.vertices
    both = Mesh(np.concatenate([x + [2, 0, 0], x * [-1, 1, 1] - [2, 0, 0]]),
                np.concatenate([small_mesh.faces, small_mesh.faces[:, ::-1] + len(x)]))  # fmt: skip
    found = rigid(both, moved(both, TURNS[0]))
    assert found.ties == ["side"]
    assert not found.best.mirrored


def test_what_has_no_counterpart_is_told(small_mesh):
    there = small_mesh.vertices[small_mesh.faces].mean(axis=1)[:, 0] < 0.5
    part = Mesh(small_mesh.vertices, small_mesh.faces[there])
    share = 1 - part.area / small_mesh.area
    found = rigid(moved(part, TURNS[0]), small_mesh).best
    assert angles(found.rotation @ TURNS[0]) < 10
    assert 0.5 * share < found.missing <= share
    assert found.extra < 0.05


def test_angles():
    turn = Rotation.from_rotvec([0, 0, 0.5]).as_matrix()
    expected = np.degrees(0.5)
    np.testing.assert_allclose(angles(np.stack([turn, turn @ np.diag([1, 1, -1])])), expected)
    assert angles(np.diag([-1.0, 1, 1])) == 0


def test_errors(small_mesh):
    with pytest.raises(InputError, match="mirror=yes: expected one of auto, forbid, allow"):
        rigid(small_mesh, small_mesh, mirror="yes")
    with pytest.raises(InputError, match="a single place"):
        sampled(PointCloud(np.ones((5, 3))))


def _subdivided(mesh):
    import trimesh

    return Mesh(*trimesh.remesh.subdivide(mesh.vertices, mesh.faces))
