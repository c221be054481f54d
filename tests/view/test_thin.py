import numpy as np
import pytest
import trimesh

from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.view.thin import thin

BALL = trimesh.creation.icosphere(5)


def test_a_thinned_mesh_is_the_same_surface():
    mesh = Mesh(BALL.vertices, BALL.faces)
    few, kept = thin(mesh, 2000)
    assert 800 < len(few.vertices) <= 2000
    np.testing.assert_array_equal(few.vertices, mesh.vertices[kept])
    assert few.area == pytest.approx(mesh.area, rel=0.02)
    assert trimesh.Trimesh(few.vertices, few.faces, process=False).volume > 0  # still oriented outward


def test_a_cloud_too_and_small_shapes_stay():
    few, kept = thin(PointCloud(BALL.vertices), 500)
    assert isinstance(few, PointCloud)
    assert len(kept) == len(np.unique(kept)) == len(few.points) <= 500
    mesh = Mesh(BALL.vertices, BALL.faces)
    same, kept = thin(mesh, len(BALL.vertices))
    assert same is mesh
    np.testing.assert_array_equal(kept, np.arange(len(BALL.vertices)))
