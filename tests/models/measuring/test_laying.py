import numpy as np
import pytest
import trimesh

from lssd_learn.collections.generated.skinned import LOOSE, some_turns
from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.fit import FIRST, Scan, settled
from lssd_learn.models.measuring.laying import FEW, Layer
from lssd_learn.models.measuring.posable import Pose
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.sampling import sample


@pytest.fixture(scope="module")
def layer(figure):
    drawn = np.random.default_rng(0).normal(size=(8, 6))
    return Layer(figure, LOOSE, drawn, some_turns(8, 10, 0))


@pytest.fixture(scope="module")
def person(figure):
    weights, turns = 0.7 * np.random.default_rng(3).normal(size=12), some_turns(8, 10, 0)[2].copy()
    turns[0] = trimesh.transformations.random_rotation_matrix(np.random.default_rng(4).random(3))[:3, :3]
    pose = Pose(weights, turns, np.array([3.0, -2.0, 1.0]))
    return pose, Mesh(figure.body.lying(pose).points, figure.body.faces)


def test_a_body_is_laid_on_itself_turned_anyhow_to_a_hundredth_of_a_millimetre(layer, person, figure):
    pose, mesh = person
    fit = layer.lay(mesh)
    assert fit.off < 1e-4
    assert fit.missing == fit.extra == 0
    np.testing.assert_allclose(figure.measured(fit.pose.weights), figure.measured(pose.weights), rtol=3e-3)


def test_a_cloud_lies_as_its_mesh_does(layer, person, figure):
    pose, mesh = person
    fit = layer.lay(PointCloud(sample(mesh, 6000, np.random.default_rng(0))))
    assert fit.off < 1e-3
    np.testing.assert_allclose(figure.measured(fit.pose.weights), figure.measured(pose.weights), rtol=0.01)


def test_what_is_cut_off_is_told_as_missing(layer, person):
    mesh = person[1]
    axis = np.linalg.eigh(np.cov(mesh.vertices.T))[1][:, 2]
    along = mesh.vertices @ axis
    stays = along < np.quantile(along, 0.8)
    half = Mesh(mesh.vertices, mesh.faces[stays[mesh.faces].all(1)])
    scan = Mesh(half.vertices[np.unique(half.faces)], np.unique(half.faces, return_inverse=True)[1].reshape(-1, 3))
    assert layer.lay(scan).missing > 0.02


def test_a_mesh_that_is_inside_out_is_the_same_scan(person):
    mesh = person[1]
    surface = mesh.vertices[:FEW]
    one, other = Scan.of(mesh, surface), Scan.of(Mesh(mesh.vertices, mesh.faces[:, ::-1]), surface)
    there = cKDTree(other.points)
    away, same = there.query(one.points)
    assert (away == 0).sum() > 1000  # others are not looked at
    np.testing.assert_allclose(one.normals[away == 0], other.normals[same[away == 0]], atol=1e-12)


def test_the_nearest_start_is_the_person_itself_and_the_first_rounds_bring_it_nearer(layer, person):
    mesh = person[1]
    surface = sample(mesh, FEW, np.random.default_rng(0))
    pose = layer.starts.nearest(surface, 1)[0]
    scan = Scan.of(mesh, surface)
    after = settled(layer.coarse, layer.loose, scan, pose, FIRST)
    goals = mesh.vertices[layer.spread]
    before, then = (np.linalg.norm(layer.coarse.lying(p).points - goals, axis=1).mean() for p in (pose, after))
    assert then < 0.6 * before
