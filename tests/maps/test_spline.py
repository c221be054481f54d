import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bumps, ShapeList
from lssd_learn.errors import InputError
from lssd_learn.latent import MapNetwork
from lssd_learn.maps import SplineMaps
from lssd_learn.maps.spline import Spline, spline_vertices
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, PointCloud


@pytest.mark.parametrize("rounds", [0, 4])
def test_an_affine_copy_is_found_exactly(twins, rounds):
    """However it is turned, moved, scaled and sheared, and whatever the order of its vertices."""
    A = 30 * Rotation.random(rng=np.random.default_rng(0)).as_matrix() @ [[1.0, 0.2, 0], [0, 0.9, 0], [0, 0, 1.2]]
    target = Mesh(twins.target_shape.vertices @ A.T + 100, twins.target_shape.faces)
    marks = twins.source_landmarks, twins.target_landmarks
    there, back = spline_vertices(twins.source_shape, target, *marks, Spline(rounds, 200))
    np.testing.assert_array_equal(there, twins.true)
    np.testing.assert_array_equal(back, np.argsort(twins.true))
    clouds = PointCloud(twins.source_shape.vertices), PointCloud(target.vertices)
    np.testing.assert_array_equal(spline_vertices(*clouds, *marks, Spline(rounds, 200))[0], there)


def errors(marks, rounds, subdivisions=3):
    """Mean distance, on a sphere with two bumps, to the vertex that is the true one on a sphere without."""
    plain, bumpy = Bumps(heights=[[0, 0], [0.5, 0.4]], subdivisions=subdivisions)
    there, back = spline_vertices(plain, bumpy, marks, marks, Spline(rounds))
    return np.mean([np.linalg.norm(plain.vertices[found] - plain.vertices, axis=1).mean() for found in (there, back)])


def test_matched_points_make_up_for_landmarks():
    few = np.array([0, 20, 40, 60, 80])
    alone, refined = errors(few, 0), errors(few, 6)
    assert refined < 0.9 * alone
    assert refined < 0.08  # half an edge is .07


def test_landmarks_at_one_vertex_count_once(twins):
    marks = [np.concatenate([m, m[:3]]) for m in (twins.source_landmarks, twins.target_landmarks)]
    there, _ = spline_vertices(twins.source_shape, twins.target_shape, *marks, Spline(2, 100))
    np.testing.assert_array_equal(there, twins.true)


def test_a_collection(shuffled):
    spheres = [*Bumps(subdivisions=3)]
    mixed = ShapeList([*spheres[:2], *(shuffled(mesh)[0] for mesh in spheres[2:])])
    back = np.argsort(shuffled(spheres[0])[1])
    marks = np.arange(0, 60, 5)
    mixed.landmarks = [dict(enumerate(marks))] * 2 + [dict(enumerate(back[marks]))] * 2
    sizes = {"k": 30, "size": 20, "keep": 10, "cache": None, "network": MapNetwork.clique}
    area, true = (Pipeline(c, maps=SplineMaps, **sizes).operators()[:, 0] for c in (mixed, ShapeList(spheres)))
    spectra, expected = torch.linalg.eigvalsh(area), torch.linalg.eigvalsh(true)
    assert (spectra - expected).norm() < 0.5 * (expected - 1).norm()


def test_too_little_to_go_by(twins):
    flat = np.flatnonzero(np.abs(twins.source_shape.vertices[:, 0]) < 1e-6)[:6]
    for marks in (twins.source_landmarks[:3], flat):
        with pytest.raises(InputError, match="expected four landmarks or more that are not in one plane, got"):
            spline_vertices(twins.source_shape, twins.source_shape, marks, marks)
    for wrong in ({"rounds": -1}, {"samples": 0}):
        with pytest.raises(InputError, match=f"maps.{next(iter(wrong))}="):
            spline_vertices(twins.source_shape, twins.source_shape, twins.true[:8], twins.true[:8], Spline(**wrong))
