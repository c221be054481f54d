import numpy as np
import pytest
import trimesh

from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.normals import normals


@pytest.mark.parametrize("kind", [Mesh, PointCloud])
def test_those_of_a_sphere_are_its_points(kind):
    sphere = trimesh.creation.icosphere(4)
    shape = Mesh(sphere.vertices, sphere.faces) if kind is Mesh else PointCloud(sphere.vertices)
    along = np.einsum("vx,vx->v", normals(shape), sphere.vertices)
    assert (along if kind is Mesh else np.abs(along)).min() > 0.999
    np.testing.assert_allclose(np.linalg.norm(normals(shape), axis=1), 1)


def test_where_triangles_face_each_other_there_is_none():
    two = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]])
    np.testing.assert_array_equal(normals(two), 0)
