"""Laws of extrinsic differences and of the Gram form, on deformed spheres."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch
from scipy.stats import special_ortho_group

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, extrinsic_difference, gram, push_all, smooth_embedding
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.latent.differences import Seen, stack_differences
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Eigenbasis, Mesh, PointCloud, eigenbasis
from lssd_learn.shapes.moments import moments

EXTRINSIC = ["extrinsic"]


def operators(seen):
    return stack_differences(seen, EXTRINSIC)[:, 0]


@pytest.fixture(scope="module")
def bases(meshes):
    return [eigenbasis(mesh, 24) for mesh in meshes]


@pytest.fixture(scope="module")
def latent(bases):
    return LatentSpace.fit(MapNetwork.clique(bases), 18, 12)


@pytest.fixture(scope="module")
def complete(deformed_spheres, full_basis):
    """Three spheres of 42 vertices with all their functions, measured."""
    found = []
    for mesh in deformed_spheres(3, 1):
        basis = full_basis(mesh)
        basis = replace(basis, evecs=basis.evecs * np.sign(basis.evecs[0, 0]))
        found.append(replace(basis, measure=partial(moments, mesh.vertices, basis.mass, basis.evecs)))
    return found


def moved(basis, mesh, s=1.0):
    """The eigenbasis of a shape turned, shifted and scaled by s."""
    R = special_ortho_group.rvs(3, random_state=1)
    mass, evecs = basis.mass * s**2, basis.evecs / s
    measure = partial(moments, s * mesh.vertices @ R + [3, -2, 5], mass, evecs)
    return Eigenbasis(basis.evals / s**2, evecs, mass, basis.connectivity, measure)


def test_identical_shapes_are_the_identity_but_for_the_constant(bases):
    D = operators(LatentSpace.fit(MapNetwork.clique([bases[0]] * 3), 12, 8))
    expected = torch.eye(8, dtype=torch.float64)
    expected[0, 0] = 0
    torch.testing.assert_close(D, expected.expand(3, 8, 8), rtol=0, atol=1e-10)


def test_neither_rigid_motions_nor_sizes_change_anything(meshes, bases, latent):
    turned = [moved(basis, mesh) for basis, mesh in zip(bases, meshes, strict=True)]
    torch.testing.assert_close(operators(replace(latent, bases=turned, references={})), operators(latent))
    seen = BaseShapes(MapNetwork.clique(bases), 10).differences(0, EXTRINSIC)[0]
    larger = BaseShapes(
        MapNetwork.clique([bases[0], *(moved(b, m, 1.5) for b, m in zip(bases[1:], meshes[1:], strict=True))]), 10
    )
    found = larger.differences(0, EXTRINSIC)[0]
    torch.testing.assert_close(found[0, 1:, 1:], torch.eye(9, dtype=torch.float64))
    torch.testing.assert_close(found[1:], seen[1:])


def test_both_forms_have_the_same_eigenvalues_and_signs_of_functions_go_with_them(latent):
    D, plain = operators(latent), extrinsic_difference(latent)
    torch.testing.assert_close(torch.linalg.eigvals(plain).real.sort(1)[0], torch.linalg.eigvalsh(D), rtol=0, atol=1e-9)
    s = torch.tensor([1.0, -1.0] * 6).double()
    flipped = operators(replace(latent, Y=latent.Y * s, references={}))
    torch.testing.assert_close(flipped, s[:, None] * D * s)


def test_of_shapes_in_two_pieces_the_same_functions_are_null_as_of_conformal_ones(deformed_spheres):
    pairs = [
        Mesh(np.vstack([mesh.vertices, mesh.vertices + [4, 0, i]]), np.vstack([mesh.faces, mesh.faces + 42]), pieces=2)
        for i, mesh in enumerate(deformed_spheres(3, 1))
    ]
    space = LatentSpace.fit(MapNetwork.clique([eigenbasis(pair, 20) for pair in pairs]), 16, 12)
    D, C = stack_differences(space, ["extrinsic", "conformal"]).unbind(1)
    assert torch.equal(D.any(0).any(0), C.any(0).any(0))
    live = D.any(0).any(0)
    assert live.sum() == 10
    torch.testing.assert_close(D.mean(0)[live][:, live], torch.eye(10).double(), rtol=0, atol=1e-9)
    assert (torch.linalg.eigvalsh(D[:, live][:, :, live]) > 0.01).all()


def test_functoriality_where_nothing_is_truncated(complete):
    """D_ac = D_ab C_ab⁻¹ D_bc C_ab in the defining form, on functions of mean zero; vertex identity maps."""
    k, network = complete[0].k, MapNetwork.clique(complete)

    def C(i, j):
        return torch.as_tensor(np.array(network.map(i, j))).double()

    def D(i, j):
        spectrum, eye = torch.tensor(complete[i].evals), torch.eye(k).double()[None]
        source = Seen(eye, spectrum[None], spectrum, [complete[i]])
        there = Seen(C(i, j)[None], torch.tensor(complete[j].evals)[None], spectrum, [complete[j]], source)
        return extrinsic_difference(there)[0, 1:, 1:]

    C01 = C(0, 1)[1:, 1:]
    composed = D(0, 1) @ torch.linalg.solve(C01, D(1, 2) @ C01)
    torch.testing.assert_close(composed, D(0, 2), rtol=0, atol=1e-7 * float(D(0, 2).abs().max()))


def test_the_reference_is_of_the_shapes_that_the_space_was_fitted_to(bases, latent, tmp_path):
    D = operators(latent)
    eye = np.eye(24)
    torch.testing.assert_close(latent.push(bases[2], {2: (eye, eye)}).difference("extrinsic"), D[2], rtol=0, atol=1e-8)
    fresh = LatentSpace.fit(MapNetwork.clique(bases), 18, 12)
    pushed = push_all(fresh, bases[3:5], ["a", "b"], neighbours=1)
    torch.testing.assert_close(operators(pushed), D[3:5], rtol=0, atol=1e-6)  # computed from `fresh`, not from two
    torch.testing.assert_close(operators(fresh.some([3, 4])), D[3:5])
    few = fresh.averaging([0, 1, 2])
    expected = torch.eye(12).double()
    expected[0, 0] = 0
    torch.testing.assert_close(operators(few)[:3].mean(0), expected, rtol=0, atol=1e-9)
    whole = LatentSpace.load(latent.save(tmp_path / "whole.npz", bases=True))
    torch.testing.assert_close(operators(whole), D)
    alone = LatentSpace.load(latent.save(tmp_path / "alone.npz"))
    new = alone.push(bases[2], {2: (eye, eye)})
    torch.testing.assert_close(new.difference("extrinsic"), D[2], rtol=0, atol=1e-8)
    torch.testing.assert_close(operators(latent.with_keep(7)), operators(replace(latent, references={}).with_keep(7)))
    torch.testing.assert_close(operators(latent.to("cpu")), D)
    unasked = replace(few, references={})
    old = LatentSpace.load(unasked.save(tmp_path / "old.npz", bases=True))
    with pytest.raises(
        InputError, match="^extrinsic: .*saved before anybody asked it for extrinsic operators.* fit it again"
    ):
        old.push(bases[2], {2: (eye, eye)}).difference("extrinsic")


def test_a_cloud_has_nearly_the_operator_of_the_mesh_whose_vertices_it_is(meshes, bases, latent):
    """Its masses and functions are those of another Laplacian; maps point by point."""
    cloud = eigenbasis(PointCloud(meshes[1].vertices), 24)
    to_cloud = cloud.evecs.T @ (cloud.mass[:, None] * bases[1].evecs)
    from_cloud = bases[1].evecs.T @ (bases[1].mass[:, None] * cloud.evecs)
    D = latent.push(cloud, {1: (to_cloud, from_cloud)}).difference("extrinsic")
    wanted = operators(latent)[1]
    assert (D - wanted).norm() < 0.1 * wanted.norm()
    assert (D - wanted).norm() < 0.3 * min((other - wanted).norm() for other in operators(latent)[[0, 2, 3, 4, 5]])


def test_without_coordinates_it_is_refused(bases, latent):
    blind = replace(latent, bases=[replace(basis, measure=None) for basis in bases], references={})
    with pytest.raises(InputError, match="^extrinsic: expected eigenbases with moments, that of shape 0 has none"):
        operators(blind)
    with pytest.raises(InputError, match="^extrinsic: expected a latent space with its eigenbases"):
        gram(replace(latent, bases=None))


def test_the_embedding_comes_back_from_the_gram_form(complete, meshes, bases, latent):
    """Up to a rotation or reflection: all of it where nothing is truncated, otherwise the more the more functions."""

    def error(points, mesh, mass):
        X = mesh.vertices - mass @ mesh.vertices / mass.sum()
        U, _, Vt = np.linalg.svd((points * mass[:, None]).T @ X)
        return np.sqrt(mass @ np.square(points @ U @ Vt - X).sum(1) / (mass @ np.square(X).sum(1)))

    G = gram(latent)
    assert (torch.linalg.matrix_rank(G, rtol=1e-9) == 3).all()
    torch.testing.assert_close(
        gram(replace(latent, bases=[moved(b, m) for b, m in zip(bases, meshes, strict=True)])), G
    )
    torch.testing.assert_close(smooth_embedding(G) @ smooth_embedding(G).mT, G)
    errors = []
    for keep in (4, 8, 12):
        space = latent.with_keep(keep)
        points = space.to_shape(smooth_embedding(gram(space)[2]), 2).numpy()
        errors.append(error(points, meshes[2], bases[2].mass))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.1
    basis = complete[0]
    whole = Seen(torch.eye(basis.k).double()[None], torch.tensor(basis.evals)[None], torch.tensor(basis.evals), [basis])
    points = basis.evecs @ smooth_embedding(gram(whole)[0]).numpy()
    vertices = basis.evecs @ basis.moments.coordinates  # all functions: the coordinates themselves
    assert error(points, Mesh(vertices, [[0, 1, 2]]), basis.mass) < 1e-7


def test_moments_are_made_when_asked_for_and_kept(spheres, cache):
    choices = {"k": 12, "size": 10, "keep": 6, "cache": cache, "workers": 1}
    first = Pipeline(spheres(), **choices)
    first.operators(["area", "conformal"])
    assert not (cache.root / "moments").exists()
    found = first.operators(["area", "extrinsic"])
    assert len(list((cache.root / "moments").glob("*/*.arrays"))) == 6
    again = Pipeline(spheres(), **choices)
    stored = again.latent.bases
    assert torch.equal(again.operators(["area", "extrinsic"]), found)
    np.testing.assert_array_equal(stored[[4, 1]][0].moments.form, stored[4].moments.form)
    memory = Pipeline(spheres(key=None), **choices).operators(["extrinsic"])
    torch.testing.assert_close(memory[:, 0], found[:, 1], rtol=0, atol=1e-6)


def test_shapes_that_a_space_was_not_fitted_to_have_no_part_in_its_reference(spheres, cache):
    choices = {"k": 12, "size": 10, "keep": 6, "fitted": [0, 2, 3, 5], "workers": 1}
    expected = torch.eye(6).double()
    expected[0, 0] = 0
    for key in ("spheres", None):
        D = Pipeline(spheres(key=key), **choices, cache=cache).operators(["extrinsic"])[:, 0]
        torch.testing.assert_close(D[[0, 2, 3, 5]].mean(0), expected, rtol=0, atol=1e-8)
        assert (D.mean(0) - expected).abs().max() > 1e-3
