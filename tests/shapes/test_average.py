import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, average_eigenbasis, eigenbasis, laplacian


def test_the_average_of_one_shape_is_that_shape(meshes):
    np.testing.assert_allclose(
        average_eigenbasis([meshes[0]] * 3, 12).evals, eigenbasis(meshes[0], 12).evals, rtol=1e-9, atol=1e-9
    )


def test_it_solves_the_averaged_problem(meshes):
    basis = average_eigenbasis(iter(meshes), 12)
    L, M = (sum(part) / len(meshes) for part in zip(*map(laplacian, meshes), strict=True))
    np.testing.assert_allclose(basis.mass, M)
    np.testing.assert_allclose(L @ basis.evecs, M[:, None] * basis.evecs * basis.evals, atol=1e-8)
    np.testing.assert_allclose(basis.evecs.T * M @ basis.evecs, np.eye(12), atol=1e-10)
    assert basis.connectivity == meshes[0].connectivity


def test_shapes_without_an_average(meshes):
    other = Mesh(meshes[1].vertices, meshes[1].faces[::-1])
    with pytest.raises(InputError, match="an average needs meshes with the same faces, number 2 differs"):
        average_eigenbasis([meshes[0], meshes[1], other], 5)
    with pytest.raises(InputError, match="number 0 differs"):
        average_eigenbasis([PointCloud(meshes[0].vertices)], 5)
    with pytest.raises(InputError, match="k: expected 1 to 161, fewer than the vertices of 6 shapes, got 162"):
        average_eigenbasis(meshes, 162)
    with pytest.raises(InputError, match="of 0 shapes"):
        average_eigenbasis([], 1)
