"""Shapes of several connected pieces: one function of frequency zero a piece, and what follows downstream."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.maps import landmarks
from lssd_learn.shapes import Mesh, eigenbasis


def joined(*meshes):
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    vertices = [mesh.vertices + [10 * i, 0, 0] for i, mesh in enumerate(meshes)]
    return Mesh(np.concatenate(vertices), np.concatenate(faces), len(meshes))


@pytest.fixture(scope="module")
def pairs(deformed_spheres):
    """Four shapes of two pieces each, and one of three."""
    meshes = deformed_spheres(8, 2)
    return [joined(*meshes[i : i + 2]) for i in range(0, 8, 2)], joined(*meshes[:3])


def test_the_spectrum_is_that_of_the_pieces_together(pairs, deformed_spheres):
    """Three pieces of some size, in a dense and in a sparse solver."""
    for subdivisions in (2, 3):
        meshes = deformed_spheres(3, subdivisions)
        whole = eigenbasis(joined(*meshes), 20)
        alone = np.sort(np.concatenate([eigenbasis(mesh, 20).evals for mesh in meshes]))[:20]
        assert (whole.evals[:3] == 0).all()
        np.testing.assert_allclose(whole.evals[3:], alone[3:], rtol=1e-7)
        gram = whole.evecs.T @ (whole.mass[:, None] * whole.evecs)
        np.testing.assert_allclose(gram, np.eye(20), atol=1e-9)


def test_the_null_functions_are_constant_on_each_piece(pairs):
    basis = eigenbasis(pairs[1], 10)
    for part in np.split(basis.evecs[:, :3], 3):
        np.testing.assert_allclose(part, np.broadcast_to(part[0], part.shape), atol=1e-12)
    assert np.ptp(basis.evecs[:, 0]) == 0


def test_pieces_that_nobody_asked_for_are_refused(pairs):
    unasked = Mesh(pairs[0][0].vertices, pairs[0][0].faces)
    with pytest.raises(InputError, match="expected one connected piece, got 2"):
        eigenbasis(unasked, 10)
    with pytest.raises(InputError, match="k: expected 3 or more, one for each connected piece, got 2"):
        eigenbasis(pairs[1], 2)


def test_identical_shapes_have_identity_operators(pairs):
    bases = [eigenbasis(pairs[0][0], 20)] * 3
    latent = LatentSpace.fit(MapNetwork.clique(bases), 16, 12)
    area, conformal = latent.differences()
    np.testing.assert_allclose(area, np.broadcast_to(np.eye(12), area.shape), atol=1e-8)
    due = np.diag([0.0, 0.0, *[1.0] * 10])  # two functions are null
    np.testing.assert_allclose(conformal, np.broadcast_to(due, conformal.shape), atol=1e-6)


def test_the_operators_are_those_of_the_pieces(deformed_spheres):
    """One piece grows, the other stays: in areas the operator knows the factor, on the piece that grew alone."""
    a, b = deformed_spheres(2, 2)
    shapes = [joined(Mesh(s * a.vertices, a.faces), b) for s in (1.0, 1.1, 1.2)]
    latent = LatentSpace.fit(MapNetwork.clique([eigenbasis(shape, 30) for shape in shapes]), 20, 12)
    area, conformal = latent.differences(symmetric=True)
    assert conformal.isfinite().all()
    assert conformal.abs().max() < 10
    values = np.linalg.eigvalsh(area.numpy())
    mean = (1 + 1.1**2 + 1.2**2) / 3
    for i, s in enumerate((1.0, 1.1, 1.2)):
        assert values[i].min() == pytest.approx(min(1, s**2 / mean), rel=1e-2)
        assert values[i].max() == pytest.approx(max(1, s**2 / mean), rel=1e-2)


def test_landmarks_map_piece_to_piece(pairs):
    """Of one shape onto itself: near the identity, no vertex to the other piece."""
    basis = eigenbasis(pairs[0][0], 20)
    marks = [3, 50, 90, 140, 170, 200, 260, 310]
    C = landmarks(basis, basis, marks, marks)
    np.testing.assert_allclose(C, np.eye(20), atol=1e-6)
