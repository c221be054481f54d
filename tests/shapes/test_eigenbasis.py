import sys

import numpy as np
import pytest
import scipy.sparse.linalg
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import diags_array
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
