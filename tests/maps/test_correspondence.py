"""A functional map is the best approximation of carrying functions from vertex to vertex."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.maps import from_correspondence
from lssd_learn.shapes import Eigenbasis, Mesh, eigenbasis, laplacian


@pytest.fixture(scope="module")
def bases(deformed_spheres):
    """Two spheres of one connectivity, 162 vertices."""
    return [eigenbasis(mesh, k) for mesh, k in zip(deformed_spheres(2, 2), (20, 25), strict=True)]


@pytest.fixture(scope="module")
def other(deformed_spheres):
    """A sphere of 42 vertices."""
    return eigenbasis(deformed_spheres(1, 1, seed=1)[0], 15)


def least_squares(source, target, vertices):
    """The C that makes ‖Φ_t C − Π Φ_s‖ least in the measure of the target, column after column."""
    root = np.sqrt(target.mass)
    carried = np.zeros((len(target.mass), len(source.mass)))
    carried[np.arange(len(target.mass)), vertices] = 1
    right = carried @ source.evecs
    columns = [np.linalg.lstsq(root[:, None] * target.evecs, root * f)[0] for f in right.T]
    return np.stack(columns, axis=1)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_it_is_the_least_squares_map_of_any_vertex_map(bases, other, seed):
    rng = np.random.default_rng(seed)
    for source, target in ((bases[0], other), (other, bases[1]), (bases[0], bases[1])):
        vertices = rng.integers(0, len(source.mass), len(target.mass))
        C = from_correspondence(source, target, vertices)
        assert C.shape == (target.k, source.k)
        np.testing.assert_allclose(C, least_squares(source, target, vertices), atol=1e-10)


def test_vertex_identity_is_the_vertex_map_that_says_so(bases):
    C = from_correspondence(*bases)
    np.testing.assert_allclose(C, from_correspondence(*bases, np.arange(162)), atol=1e-14)
    np.testing.assert_allclose(C, least_squares(*bases, np.arange(162)), atol=1e-10)


def test_a_shape_and_itself_have_the_identity(bases):
    np.testing.assert_allclose(from_correspondence(bases[0], bases[0]), np.eye(20), atol=1e-12)


def test_constants_stay_constants(bases):
    """The first column: √(area ratio) on the target's constant, nothing elsewhere."""
    C = from_correspondence(*bases)
    expected = np.eye(25)[0] * np.sqrt(bases[1].area / bases[0].area)
    np.testing.assert_allclose(C[:, 0], expected, atol=1e-10)


def test_the_order_of_the_vertices_does_not_matter(deformed_spheres, bases):
    mesh, order = deformed_spheres(2, 2)[0], np.random.default_rng(0).permutation(162)
    back = np.argsort(order)
    shuffled = eigenbasis(Mesh(mesh.vertices[order], back[mesh.faces]), 20)
    C = from_correspondence(bases[0], shuffled, order)
    np.testing.assert_allclose(np.abs(C), np.eye(20), atol=1e-7)
    to = from_correspondence(bases[0], bases[1])
    np.testing.assert_allclose(from_correspondence(shuffled, bases[1], back) @ C, to, atol=1e-7)


def test_full_maps_compose_and_transpose_to_the_adjoint(deformed_spheres):
    """With as many functions as vertices: C_jk C_ij = C_ik, and the adjoint belongs to the masses."""
    full = []
    for mesh in deformed_spheres(3, 1):
        L, M = laplacian(mesh)
        full.append(Eigenbasis(*scipy.linalg.eigh(L.toarray(), np.diag(M)), M, mesh.connectivity))
    C = [[from_correspondence(a, b) for b in full] for a in full]
    np.testing.assert_allclose(C[1][2] @ C[0][1], C[0][2], atol=1e-9)
    np.testing.assert_allclose(C[1][0] @ C[0][1], np.eye(42), atol=1e-9)
    f, g = np.random.default_rng(0).normal(size=(2, 42))
    carried = full[1].evecs @ (C[0][1] @ (np.linalg.solve(full[0].evecs, f)))
    np.testing.assert_allclose(carried, f, atol=1e-9)
    inner = (full[1].mass * f) @ g
    a, b = (np.linalg.solve(full[1].evecs, h) for h in (f, g))
    assert a @ b == pytest.approx(inner)


def test_float32_bases_give_the_map_of_float64(bases):
    single = [Eigenbasis(b.evals, b.evecs.astype(np.float32), b.mass, b.connectivity) for b in bases]
    C = from_correspondence(*single)
    assert C.dtype == np.float32
    np.testing.assert_allclose(C, from_correspondence(*bases), atol=2e-6)


def test_impossible_correspondences_are_refused(bases, other):
    with pytest.raises(ValueError, match="vertex identity needs two shapes of one connectivity; give the vertices"):
        from_correspondence(bases[0], other)
    same_size = Eigenbasis(bases[1].evals, bases[1].evecs, bases[1].mass, "other")
    with pytest.raises(ValueError, match="vertex identity needs two shapes of one connectivity"):
        from_correspondence(bases[0], same_size)
    with pytest.raises(ValueError, match="vertices: expected one for each of the 42 target vertices, got 162"):
        from_correspondence(bases[0], other, np.zeros(162, int))
