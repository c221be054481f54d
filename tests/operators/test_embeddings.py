"""Shapes of Gram forms: their own come back whole, others smooth and with a neighbour's detail."""

import numpy as np
import pytest
import torch
from scipy.stats import special_ortho_group

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, gram
from lssd_learn.latent.extrinsic import latent_coordinates
from lssd_learn.latent.orthogonal import nearest_orthogonal
from lssd_learn.operators import shapes_of_gram
from lssd_learn.shapes import Mesh, eigenbasis
from lssd_learn.shapes.kabsch import vertex_error


@pytest.fixture(scope="module")
def meshes(deformed_spheres):
    """Six deformed spheres with a fine pattern that they share."""
    found = deformed_spheres(6, 2)
    pattern = 0.2 * np.sin(9 * np.mean([mesh.vertices for mesh in found], axis=0))
    return [Mesh(mesh.vertices + pattern, mesh.faces) for mesh in found]


@pytest.fixture(scope="module")
def known(meshes):
    return LatentSpace.fit(MapNetwork.clique([eigenbasis(mesh, 30) for mesh in meshes]), 25, 16)


def test_known_shapes_come_back_whole(known, meshes):
    for i, laid in enumerate(shapes_of_gram(gram(known), known, meshes)):
        assert laid.nearest == i
        assert laid.apart < 1e-6
        np.testing.assert_allclose(laid.vertices, meshes[i].vertices, rtol=0, atol=1e-6)


def test_others_are_nearer_with_the_detail_of_a_neighbour(known, meshes):
    """Each shape in turn from the space's others: nearer than its smooth part, and than the neighbour itself."""
    errors = []
    for i, mesh in enumerate(meshes):
        others = [j for j in range(6) if j != i]
        (laid,) = shapes_of_gram(gram(known)[i : i + 1], known.some(others), [meshes[j] for j in others])
        near = meshes[others[laid.nearest]].vertices
        errors.append([vertex_error(x, mesh.vertices) for x in (laid.vertices, laid.smooth, near)])
        assert laid.apart > 0.05
    detailed, smooth, nearest = np.mean(errors, axis=0)
    assert detailed < 0.8 * smooth
    assert detailed < 0.5 * nearest


@pytest.mark.parametrize("turned_is_better", [True, False])
def test_detail_turns_where_that_drew_known_shapes_better(known, meshes, monkeypatch, turned_is_better):
    """Farther than any of these from its neighbour it turns in any case."""
    asked = []

    def turned(mesh, before, after, measure):
        asked.append(mesh)
        truth = min(meshes[:5], key=lambda other: np.abs(mesh.vertices + after - before - other.vertices).max())
        return truth.vertices if turned_is_better else mesh.vertices

    monkeypatch.setattr("lssd_learn.operators.embeddings.with_turned_detail", turned)
    some, G = known.some(range(5)), gram(known)[5:]
    shapes_of_gram(G, some, meshes[:5])
    assert len(asked) == 5 + turned_is_better
    shapes_of_gram(9 * G, some, meshes[:5])
    assert len(asked) == 10 + turned_is_better + 1


def test_of_two_mirror_images_that_whose_faces_look_outward(known, meshes):
    """Though the other one may lie nearer to every shape that is known."""
    x, rng, mirrored = latent_coordinates(known), np.random.default_rng(0), 0
    for _ in range(400):
        flat = x[0] * torch.tensor([1, 1, 0.02]) + torch.tensor(rng.normal(scale=0.1, size=x[0].shape))
        outward = all(volume(known.to_shape(flat, i).numpy(), meshes[i].faces) > 0 for i in range(6))
        turned = torch.linalg.det(nearest_orthogonal(flat.mT @ x)) > 0
        if not outward or turned.any():
            continue
        mirrored += 1
        (laid,) = shapes_of_gram((flat @ flat.mT)[None], known, meshes)
        assert vertex_error(laid.smooth, known.to_shape(flat, laid.nearest).numpy()) < 1e-6
    assert mirrored > 2


def volume(vertices, faces):
    a, b, c = (vertices - vertices.mean(0))[faces].transpose(1, 0, 2)
    return np.einsum("fi,fi->", np.cross(a, b), c) / 6


def test_rank_is_cut_and_what_does_not_fit_is_refused(known, meshes):
    noisy = gram(known) + 1e-9 * torch.eye(16).double()
    np.testing.assert_allclose(shapes_of_gram(noisy, known, meshes)[2].vertices, meshes[2].vertices, rtol=0, atol=1e-4)
    with pytest.raises(InputError, match="^shapes: expected the 6 of the latent space, got 2"):
        shapes_of_gram(gram(known), known, meshes[:2])
    with pytest.raises(InputError, match=r"^G: expected forms \(s, 16, 16\), got \(6, 5, 5\)"):
        shapes_of_gram(gram(known)[:, :5, :5], known, meshes)


def test_rotations_and_shifts_are_no_errors():
    rng = np.random.default_rng(0)
    x, R = rng.normal(size=(20, 3)), special_ortho_group.rvs(3, random_state=2)
    assert vertex_error(x @ R + 7, x) < 1e-12
    assert vertex_error(x * [1, 1, -1], x) > 0.1
