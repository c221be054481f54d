import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, cotangent, laplacian, normalised_area, robust


def cotangent_naive(mesh):
    """Angle by angle."""
    n = len(mesh.vertices)
    L, M = np.zeros((n, n)), np.zeros(n)
    for face in mesh.faces:
        for c in range(3):
            i, j, k = np.roll(face, c)
            u, v = mesh.vertices[j] - mesh.vertices[i], mesh.vertices[k] - mesh.vertices[i]
            weight = (u @ v) / np.linalg.norm(np.cross(u, v)) / 2
            L[[j, k], [k, j]] -= weight
            L[[j, k], [j, k]] += weight
            M[i] += np.linalg.norm(np.cross(u, v)) / 6
    return L, M


def test_a_right_triangle_by_hand():
    """Angles 90°, 45°, 45°: cotangents 0, 1, 1."""
    L, M = cotangent(Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    np.testing.assert_allclose(L.toarray(), [[1, -0.5, -0.5], [-0.5, 0.5, 0], [-0.5, 0, 0.5]], atol=1e-15)
    np.testing.assert_allclose(M, 1 / 6)


def test_the_slow_twin_agrees(small_mesh):
    L, M = cotangent(small_mesh)
    slow_L, slow_M = cotangent_naive(small_mesh)
    np.testing.assert_allclose(L.toarray(), slow_L, atol=1e-12)
    np.testing.assert_allclose(M, slow_M, rtol=1e-12)


@pytest.mark.parametrize("kind", ["cotangent", "robust"])
def test_symmetric_without_constant_and_masses_sum_to_the_area(small_mesh, kind):
    L, M = laplacian(small_mesh, kind)
    assert abs(L - L.T).max() < 1e-12
    assert np.abs(L @ np.ones(642)).max() < 1e-12
    assert np.linalg.eigvalsh(L.toarray()).min() > -1e-12
    assert M.shape == (642,)
    # The robust one thickens edges by a hundred-thousandth of their length.
    assert M.sum() == pytest.approx(small_mesh.area, rel=1e-12 if kind == "cotangent" else 1e-3)


def test_exact_on_linear_functions(square):
    """∫|∇f|² = |g|² · area for f = g · x; and L f = 0 at inner vertices."""
    mesh = square(7)
    L, _ = cotangent(mesh)
    f = mesh.vertices @ [2, -3, 0]
    assert f @ (L @ f) == pytest.approx(13)
    inner = ((mesh.vertices[:, :2] > 0.01) & (mesh.vertices[:, :2] < 0.99)).all(axis=1)
    assert np.abs((L @ f)[inner]).max() < 1e-12


def test_auto_takes_the_robust_one_only_where_needed(small_mesh):
    L, _ = laplacian(small_mesh)
    assert abs(L - cotangent(small_mesh)[0]).max() == 0
    fin = Mesh(
        np.vstack([small_mesh.vertices, [[2, 2, 2]]]), np.vstack([small_mesh.faces, [[*small_mesh.faces[0][:2], 642]]])
    )
    assert abs(laplacian(fin)[0] - robust(fin)[0]).max() == 0
    cloud = PointCloud(small_mesh.vertices)
    assert abs(laplacian(cloud)[0] - robust(cloud)[0]).max() == 0


def test_a_cloud_does_not_depend_on_where_it_stands(small_mesh):
    L, M = robust(PointCloud(small_mesh.vertices))
    moved_L, moved_M = robust(PointCloud(1e3 * (small_mesh.vertices + [0, 0, 10])))
    assert abs(L - moved_L).max() < 1e-9
    np.testing.assert_allclose(moved_M, 1e6 * M, rtol=1e-9)


def test_normalised_area(small_mesh):
    assert normalised_area(small_mesh).area == pytest.approx(1)
    assert robust(normalised_area(PointCloud(small_mesh.vertices)))[1].sum() == pytest.approx(1)


def test_errors(small_mesh):
    with pytest.raises(InputError, match="laplacian: expected one of auto cotangent robust, got 'graph'"):
        laplacian(small_mesh, "graph")
    with pytest.raises(InputError, match="cotangent needs a mesh"):
        laplacian(PointCloud(small_mesh.vertices), "cotangent")
    with pytest.raises(InputError, match="cotangent needs faces with an area, 1 of 2 have none"):
        cotangent(Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 3]]))
    with pytest.raises(InputError, match="a point cloud needs more than 30 points, got 30"):
        laplacian(PointCloud(small_mesh.vertices[:30]))
