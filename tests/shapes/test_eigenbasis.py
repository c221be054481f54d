import sys

import numpy as np
import pytest
import scipy.sparse.linalg
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_array, diags_array
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis, laplacian, shape_dna

SPHERE = np.repeat(np.arange(9), 2 * np.arange(9) + 1) * np.repeat(np.arange(1, 10), 2 * np.arange(9) + 1)  # l(l + 1)


@pytest.fixture(scope="module")
def basis(small_mesh):
    return eigenbasis(small_mesh, 50)


@pytest.mark.parametrize("k", [1, 2, 50, 300])
@pytest.mark.parametrize("kind", ["cotangent", "robust"])
def test_orthonormal_ascending_and_solves_the_problem(small_mesh, k, kind):
    basis = eigenbasis(small_mesh, k, kind)
    L, M = laplacian(small_mesh, kind)
    Phi = basis.evecs
    assert Phi.shape == (642, k)
    assert np.abs(Phi.T @ (M[:, None] * Phi) - np.eye(k)).max() < 1e-10
    assert (np.diff(basis.evals) >= 0).all()
    np.testing.assert_allclose(Phi.T @ (L @ Phi), np.diag(basis.evals), atol=1e-9 * max(basis.evals[-1], 1))
    assert np.abs(L @ Phi - M[:, None] * Phi * basis.evals).max() < 1e-6
    np.testing.assert_array_equal(basis.mass, M)


def test_the_first_function_is_a_positive_constant(small_mesh, basis):
    assert basis.evals[0] == 0
    np.testing.assert_allclose(basis.evecs[:, 0], basis.area**-0.5, rtol=1e-12)
    assert basis.area == pytest.approx(small_mesh.area)
    assert basis.connectivity == small_mesh.connectivity


@pytest.mark.parametrize("k", [20, 120])
def test_arpack_agrees(small_mesh, k):
    L, M = laplacian(small_mesh)
    evals, evecs = scipy.sparse.linalg.eigsh(L.tocsc(), k, diags_array(M).tocsc(), sigma=-0.01, v0=np.ones(642))
    basis = eigenbasis(small_mesh, k)
    np.testing.assert_allclose(basis.evals[1:], evals[1:], rtol=1e-8)
    overlap = np.abs(basis.evecs.T @ (M[:, None] * evecs)).diagonal()
    np.testing.assert_allclose(overlap, 1, atol=1e-8)


def test_the_spectrum_of_the_sphere_converges():
    """λ = l(l + 1), 2l + 1 times, with an error that falls with the square of the edge length."""
    errors = []
    for subdivisions in (2, 3, 4):
        mesh = trimesh.creation.icosphere(subdivisions)
        evals = eigenbasis(Mesh(mesh.vertices, mesh.faces), 81).evals
        errors.append(np.abs(evals[1:] / SPHERE[1:] - 1).max())
    assert errors[2] < 0.03
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


@pytest.mark.parametrize("k", [7, 61])
def test_no_copy_of_a_multiple_eigenvalue_is_missed(k):
    """The symmetries of the icosphere leave eigenvalues of multiplicity 3, 4 and 5."""
    mesh = trimesh.creation.icosphere(3)
    mesh = Mesh(mesh.vertices, mesh.faces)
    L, M = laplacian(mesh)
    exact = np.linalg.eigvalsh(L.toarray() / np.sqrt(np.outer(M, M)))[:k]
    np.testing.assert_allclose(eigenbasis(mesh, k).evals[1:], exact[1:], rtol=1e-9)


def test_the_spectrum_of_the_square_converges(square):
    """λ = π²(m² + n²), the free boundary condition."""
    m = np.arange(12)
    exact = np.sort((np.pi**2 * (m[:, None] ** 2 + m**2)).ravel())[1:30]
    errors = [np.abs(eigenbasis(square(n), 30).evals[1:] / exact - 1).max() for n in (15, 30, 60)]
    assert errors[2] < 0.01
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_a_cloud_of_the_sphere_has_nearly_its_spectrum(sphere):
    basis = eigenbasis(PointCloud(sphere.vertices), 36)
    assert basis.connectivity is None
    np.testing.assert_allclose(basis.evals[1:], SPHERE[1:36], rtol=0.05)


def test_rigid_motion_changes_nothing(small_mesh, basis):
    moved = small_mesh.vertices @ Rotation.from_rotvec([1, 2, 3]).as_matrix() + [3, -2, 10]
    other = eigenbasis(Mesh(moved, small_mesh.faces), 50)
    np.testing.assert_allclose(other.evals, basis.evals, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(other.evecs, basis.evecs, atol=1e-6)  # the signs too


@settings(max_examples=4, deadline=None)
@given(exponent=st.floats(-3, 3))
def test_scaling(small_mesh, basis, exponent):
    s = 10**exponent
    scaled = eigenbasis(Mesh(s * small_mesh.vertices, small_mesh.faces), 50)
    np.testing.assert_allclose(scaled.evals, basis.evals / s**2, rtol=1e-9)
    np.testing.assert_allclose(scaled.evecs, basis.evecs / s, atol=1e-6 / s)
    np.testing.assert_allclose(shape_dna(scaled, unit_area=True), shape_dna(basis, unit_area=True), rtol=1e-9)
    assert shape_dna(scaled) is scaled.evals


def test_a_long_thin_shape():
    """Weyl's law fails there, and with it the guess of the shift."""
    tube = trimesh.creation.cylinder(0.01, 10, sections=12).subdivide_loop(2)
    mesh = Mesh(tube.vertices, tube.faces)
    L, M = laplacian(mesh)
    exact = np.linalg.eigvalsh(L.toarray() / np.sqrt(np.outer(M, M)))[:40]
    basis = eigenbasis(mesh, 40)
    np.testing.assert_allclose(basis.evals[1:], exact[1:], rtol=1e-6)
    assert np.abs(basis.evecs.T @ (M[:, None] * basis.evecs) - np.eye(40)).max() < 1e-10


def test_the_same_bits_again(small_mesh, basis):
    again = eigenbasis(small_mesh, 50)
    assert np.array_equal(again.evals, basis.evals)
    assert np.array_equal(again.evecs, basis.evecs)


def test_signs_follow_the_rule(basis, sphere):
    skew, size = basis.mass @ basis.evecs**3, basis.mass @ np.abs(basis.evecs) ** 3
    clear = np.abs(skew) > 1e-2 * size
    assert clear.mean() > 0.7
    assert (skew[clear] > 0).all()
    odd = eigenbasis(sphere, 4)
    np.testing.assert_allclose(odd.mass @ odd.evecs[:, 1:] ** 3, 0, atol=1e-9)
    assert ((odd.mass * np.cos(np.arange(2562))) @ odd.evecs[:, 1:] > 0).all()


def test_truncate(basis):
    short = basis.truncate(20)
    assert short.k == 20
    assert short.evecs.shape == (642, 20)
    assert short.connectivity == basis.connectivity
    for k in (0, 51):
        with pytest.raises(InputError, match=f"k: expected 1 to 50, the eigenfunctions there are, got {k}"):
            basis.truncate(k)


def test_the_order_of_a_factorisation_is_found_once_for_all_of_the_same_faces(small_mesh, sphere, monkeypatch):
    module = sys.modules["lssd_learn.shapes.eigenbasis"]
    original, calls = module.spilu, []
    monkeypatch.setattr(module, "spilu", lambda *args, **how: calls.append(1) or original(*args, **how))
    module._order.cache_clear()
    stretched = Mesh(small_mesh.vertices * [1, 1, 2], small_mesh.faces)
    eigenbasis(small_mesh, 10)
    second = eigenbasis(stretched, 10)
    assert len(calls) == 1
    module._order.cache_clear()
    assert np.array_equal(eigenbasis(stretched, 10).evecs, second.evecs)  # what was known before changes no bit
    eigenbasis(sphere, 10)
    assert len(calls) == 3
    diagonal = np.eye(4)
    pattern, other = (module._Pattern(csc_array(matrix)) for matrix in (diagonal, diagonal[::-1]))
    assert pattern == module._Pattern(csc_array(2 * diagonal))
    assert pattern != other  # as many in each column


def test_the_factors_solve_in_the_order_that_is_given(small_mesh):
    L, M = laplacian(small_mesh)
    A = (L + diags_array(M)).tocsc()
    solve = sys.modules["lssd_learn.shapes.eigenbasis"].factorised(A, definite=True)
    X = np.random.default_rng(0).normal(size=(642, 3))
    np.testing.assert_allclose(A @ solve(X), X, atol=1e-9)
    np.testing.assert_allclose(A @ solve(X[:, 0]), X[:, 0], atol=1e-9)


def symmetric_shapes():
    """Spheres, tori and stars of many sizes, whose symmetries make eigenvalues repeat."""
    for subdivisions in (2, 3):
        sphere = trimesh.creation.icosphere(subdivisions)
        for squeezed in np.linspace(0.2, 1, 10):
            yield sphere.vertices * [1, 1, squeezed], sphere.faces
    for across, along in [(a, b) for a in range(8, 17) for b in range(18, 28)]:
        u, v = np.meshgrid(2 * np.pi * np.arange(along) / along, 2 * np.pi * np.arange(across) / across, indexing="ij")
        tube = 1 + 0.3 * np.cos(v)
        points = np.stack([tube * np.cos(u), tube * np.sin(u), 0.3 * np.sin(v)], -1).reshape(-1, 3)
        i, j = np.meshgrid(np.arange(along), np.arange(across), indexing="ij")
        here, right = i * across + j, (i + 1) % along * across + j
        up, both = i * across + (j + 1) % across, (i + 1) % along * across + (j + 1) % across
        yield points, np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((here, right, both), (here, both, up))])
    for arms in range(2, 11):
        for rings in range(10, 20):
            star = trimesh.creation.uv_sphere(count=[rings, 4 * arms])
            x, y, z = star.vertices.T
            radius = 1 + 0.4 * np.cos(arms * np.arctan2(y, x)) * (1 - z**2)
            yield star.vertices * radius[:, None], star.faces


def no_copy_is_missed(shapes):
    for vertices, faces in shapes:
        mesh = Mesh(vertices, faces)
        L, M = laplacian(mesh)
        exact = np.linalg.eigvalsh(L.toarray() / np.sqrt(np.outer(M, M)))[:50]
        np.testing.assert_allclose(eigenbasis(mesh, 50).evals[1:], exact[1:], rtol=1e-8)


def test_no_copy_is_missed_on_some_symmetric_shapes():
    no_copy_is_missed(list(symmetric_shapes())[::25])


@pytest.mark.slow
def test_no_copy_is_missed_on_two_hundred_symmetric_shapes():
    shapes = list(symmetric_shapes())
    assert len(shapes) == 200
    no_copy_is_missed(shapes)


@pytest.mark.parametrize("part", ["smallest_eigenpairs", "splu"])
def test_a_shift_that_fails_is_replaced_by_a_safe_one(small_mesh, basis, monkeypatch, part):
    module = sys.modules["lssd_learn.shapes.eigenbasis"]
    original, calls = getattr(module, part), []

    def fails_once(*args, **kwargs):
        calls.append(part)
        if len(calls) == 1:
            raise (ArithmeticError if part == "smallest_eigenpairs" else RuntimeError)("as if by bad luck")
        return original(*args, **kwargs)

    monkeypatch.setattr(module, part, fails_once)
    np.testing.assert_allclose(eigenbasis(small_mesh, 50).evals, basis.evals, rtol=1e-9)
    assert len(calls) == 2


def test_errors(small_mesh, sphere):
    for k in (0, 642):
        with pytest.raises(InputError, match=f"k: expected 1 to 641, fewer than the shape's 642 vertices, got {k}"):
            eigenbasis(small_mesh, k)
    both = Mesh(np.vstack([small_mesh.vertices, sphere.vertices]), np.vstack([small_mesh.faces, sphere.faces + 642]))
    with pytest.raises(InputError, match=r"shape: expected one connected piece, got 2; clean\(\) keeps the largest"):
        eigenbasis(both, 5)
    unused = Mesh(np.vstack([small_mesh.vertices, [[9, 9, 9]]]), small_mesh.faces)
    with pytest.raises(InputError, match="1 of 643 vertices have no area"):
        eigenbasis(unused, 5, "cotangent")
    with pytest.raises(InputError, match="got 2; clean"):
        eigenbasis(unused, 5)
