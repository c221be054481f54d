"""Laws of the latent space of a collection: what its operators are and what they do not depend on."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, conformal_difference, pseudo_inverse
from lssd_learn.latent import basis as basis_module
from lssd_learn.shapes import Eigenbasis, Mesh, eigenbasis

TOPOLOGIES = ["clique", "nearest", "spanning_tree", "chain", "star"]


def eye(m):
    return torch.eye(m, dtype=torch.float64)


def null_eye(m):
    """The identity but for the null direction."""
    return torch.diag(torch.arange(m) > 0).double()


@pytest.mark.parametrize("kind", TOPOLOGIES)
@pytest.mark.parametrize(("k", "size", "keep"), [(80, 64, 40), (30, 30, 30), (30, 20, 7)])
def test_the_mean_area_operator_of_bodies_is_the_identity(truncated, kind, k, size, keep, network):
    latent = LatentSpace.fit(network(kind, truncated(12, k)), size, keep)
    area, conformal = latent.differences()
    assert area.shape == conformal.shape == (12, keep, keep)
    torch.testing.assert_close(area.mean(0), eye(keep), rtol=0, atol=1e-10)
    torch.testing.assert_close(conformal.mean(0), null_eye(keep), rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", TOPOLOGIES)
def test_the_mean_area_operator_of_deformed_spheres_is_the_identity(deformed_spheres, kind, network):
    bases = [eigenbasis(mesh, 40) for mesh in deformed_spheres(8, 2)]
    area, _ = LatentSpace.fit(network(kind, bases), 32, 20).differences()
    torch.testing.assert_close(area.mean(0), eye(20), rtol=0, atol=1e-10)


def test_the_mean_area_operator_is_the_identity_where_the_network_is_solved_iteratively(body_bases, fit):
    latent = fit(body_bases + body_bases[:9], 64, 40)  # 33 · 80 functions, more than are diagonalised densely
    torch.testing.assert_close(latent.differences()[0].mean(0), eye(40), rtol=0, atol=1e-10)


def test_area_operators_are_symmetric_and_positive_definite(truncated, fit):
    area, _ = fit(truncated(12, 40)).differences()
    torch.testing.assert_close(area, area.mT, rtol=0, atol=1e-12)
    assert float(torch.linalg.eigvalsh(area).min()) > 0


@pytest.mark.parametrize("kind", TOPOLOGIES)
@pytest.mark.parametrize("size", [20, 12])
def test_identical_shapes_have_the_identity_for_operators(body_bases, kind, size, network):
    latent = LatentSpace.fit(network(kind, [body_bases[3].truncate(20)] * 6), size, size)
    area, conformal = latent.differences()
    torch.testing.assert_close(area, eye(size).expand(6, -1, -1), rtol=0, atol=1e-9)
    torch.testing.assert_close(conformal, null_eye(size).expand(6, -1, -1), rtol=0, atol=1e-8)
    symmetric = latent.differences(symmetric=True)[1]
    torch.testing.assert_close(symmetric, null_eye(size).expand(6, -1, -1), rtol=0, atol=1e-8)


def test_a_uniformly_scaled_shape_has_multiples_of_the_identity(body_meshes, fit):
    """Areas grow with the square of the scale, energies of the plane do not change."""
    mesh, scales = body_meshes[0], torch.tensor([1.0, 1.1, 0.8, 1.2], dtype=torch.float64)
    bases = [eigenbasis(Mesh(float(s) * mesh.vertices, mesh.faces), 20) for s in scales]
    area, conformal = fit(bases, 20, 20).differences()
    relative = scales**2 / (scales**2).mean()
    torch.testing.assert_close(area, relative[:, None, None] * eye(20), rtol=0, atol=1e-8)
    torch.testing.assert_close(conformal, null_eye(20).expand(4, -1, -1), rtol=0, atol=1e-7)


def test_operators_are_functorial(truncated, fit):
    """The difference from i to j, D_ij = C_ijᵀC_ij with C_ij = Y_j Y_i⁻¹, follows from the two latent ones."""
    latent = fit(truncated(8, 30), 30, 30)
    area, _ = latent.differences()
    for i, j in ((0, 1), (5, 2), (3, 3)):
        Y, C = latent.basis(i), latent.map(i, j)
        direct = C.T @ C
        through = Y @ torch.linalg.solve(area[i], area[j]) @ torch.linalg.inv(Y)
        torch.testing.assert_close(through, direct, rtol=0, atol=1e-9 * float(direct.norm()))


def test_maps_through_the_latent_shape_compose(truncated, fit):
    latent = fit(truncated(8, 30), 30, 30)
    there, back = latent.map(1, 4), latent.map(4, 1)
    torch.testing.assert_close(back @ there, eye(30), rtol=0, atol=1e-8)
    torch.testing.assert_close(latent.map(4, 6) @ there, latent.map(1, 6), rtol=0, atol=1e-8)
    torch.testing.assert_close(there @ latent.basis(1), latent.basis(4), rtol=0, atol=1e-8)


def test_rigid_motion_changes_nothing(body_meshes, truncated, fit, same_operators):
    moved = [
        Mesh(mesh.vertices @ Rotation.random(random_state=i).as_matrix() + [i, 1, -2], mesh.faces)
        for i, mesh in enumerate(body_meshes[:6])
    ]
    same_operators(fit(truncated(6, 30), 24, 16), fit([eigenbasis(m, 30) for m in moved], 24, 16), atol=1e-6)


@pytest.mark.parametrize("kind", ["clique", "chain", "nearest"])
def test_sign_flips_of_eigenfunctions_change_nothing(truncated, kind, same_operators, network):
    bases, rng = truncated(8, 30), np.random.default_rng(1)
    flipped = [Eigenbasis(b.evals, b.evecs * rng.choice([-1, 1], 30), b.mass, b.connectivity) for b in bases]
    a, b = (LatentSpace.fit(network(kind, which), 24, 16) for which in (bases, flipped))
    same_operators(a, b)


@pytest.mark.parametrize("kind", ["clique", "spanning_tree", "nearest"])
def test_the_order_of_the_collection_does_not_matter(truncated, kind, same_operators, network):
    bases, order = truncated(10, 30), np.random.default_rng(2).permutation(10)
    a, b = (LatentSpace.fit(network(kind, which), 24, 16) for which in (bases, [bases[i] for i in order]))
    same_operators(a, b, order)


def test_one_constant_factor_of_all_weights_changes_nothing(truncated, fit, same_operators):
    same_operators(
        fit(truncated(6, 20), 16, 10),
        LatentSpace.fit(MapNetwork.clique(truncated(6, 20), weights=np.full(6, 3.0)), 16, 10),
    )


def test_signs_of_latent_functions_follow_the_rule(truncated, fit):
    latent = fit(truncated(8, 30), 24, 16)
    assert ((latent.Y**3).sum((0, 1)) > 0).all()
    torch.testing.assert_close(latent.U.T @ latent.U, eye(16), rtol=0, atol=1e-12)


def test_the_latent_basis_is_canonical(truncated, fit):
    """(1/n) Σ YᵀΛY = Λ₀, ascending."""
    latent = fit(truncated(8, 30), 24, 16)
    energy = (latent.Y.mT @ (latent.evals[:, :, None] * latent.Y)).mean(0)
    torch.testing.assert_close(energy, torch.diag(latent.spectrum), rtol=0, atol=1e-9 * float(latent.spectrum[-1]))
    assert (latent.spectrum.diff() > 0).all()
    assert (latent.energy.diff() > -1e-12).all()


@pytest.mark.parametrize("size", [pytest.param(None, marks=pytest.mark.slow), "k"])
def test_with_growing_k_operators_approach_those_of_the_average_shape(
    body_meshes, truncated, fit, average, gauge, size
):
    """The paper's theorem, at ten functions."""
    evals, Phi, Ls, Ms = average(body_meshes[:24], 10)
    exact = torch.from_numpy(Phi.T @ (Ms[:, :, None] * Phi))
    inverse = np.divide(1, evals, where=evals > 1e-3 * evals[1], out=np.zeros(10))
    exact_conformal = torch.from_numpy(inverse[:, None] * (Phi.T @ Ls @ Phi))
    spread = (exact - eye(10)).norm()
    errors = []
    for k in (20, 40, 80):
        latent = fit(truncated(24, k), k if size == "k" else None, 10)
        area, conformal = latent.differences()
        s = gauge(exact, area)
        errors.append([
            float((s * area - exact).norm() / spread),
            float((s * conformal - exact_conformal).norm() / (exact_conformal - null_eye(10)).norm()),
            float(np.abs(latent.spectrum[1:].numpy() / evals[1:] - 1).max()),
        ])  # fmt: skip
    first, second, third = np.array(errors)
    assert (second < first).all()
    assert (third < second).all()
    assert (third < [0.01, 0.15, 0.03]).all()


@pytest.mark.parametrize("orthogonal", [True, False])
def test_consistent_maps_give_one_space_whatever_the_topology(spectra, orthogonal, same_operators, network):
    """C_ij = R_j R_i⁻¹ is consistent along every path."""
    n, k = 9, 12
    R = np.random.default_rng(3).normal(size=(n, k, k))
    R = np.linalg.qr(R)[0] if orthogonal else np.eye(k) + 0.15 * R
    bases = spectra(n, k)

    def maps(i, j):
        return R[j] @ np.linalg.inv(R[i])

    spaces = [LatentSpace.fit(network(kind, bases, maps=maps), k, k) for kind in TOPOLOGIES]
    spaces.append(LatentSpace.fit(MapNetwork.clusters(bases, "aabbbabab", maps), k, k))
    for latent in spaces:
        assert float(latent.energy.abs().max()) < 1e-10
        same_operators(spaces[0], latent, atol=1e-8)
    if orthogonal:
        torch.testing.assert_close(spaces[0].differences()[0], eye(k).expand(n, -1, -1), rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", TOPOLOGIES)
def test_the_iterative_solver_gives_the_operators_of_the_dense_one(
    truncated, kind, monkeypatch, same_operators, network
):
    net = network(kind, truncated(12, 30))
    dense = LatentSpace.fit(net, 24, 12)
    monkeypatch.setattr(basis_module, "DENSE_SIZE", 0)
    same_operators(dense, LatentSpace.fit(net, 24, 12, tolerance=1e-10), atol=1e-7)


@pytest.mark.parametrize("kind", ["clique", "nearest", "star"])
def test_the_default_tolerance_gives_eigenvalues_of_the_operators_to_four_digits(truncated, kind, monkeypatch, network):
    net = network(kind, truncated(12, 30))
    dense = LatentSpace.fit(net, 24, 12).differences()[0]
    monkeypatch.setattr(basis_module, "DENSE_SIZE", 0)
    rough = LatentSpace.fit(net, 24, 12).differences()[0]
    assert float((torch.linalg.eigvalsh(dense) - torch.linalg.eigvalsh(rough)).abs().max()) < 1e-4


def test_conformal_symmetric_and_standard_form_have_one_spectrum(truncated, fit):
    latent = fit(truncated(8, 40), 32, 20)
    standard, symmetric = (latent.differences(symmetric=s)[1] for s in (False, True))
    torch.testing.assert_close(symmetric, symmetric.mT, rtol=0, atol=1e-12)
    assert float(symmetric[:, 0].abs().max()) == 0
    assert float(symmetric[:, :, 0].abs().max()) == 0
    assert float(torch.linalg.eigvals(standard).imag.abs().max()) < 1e-10
    ordered = torch.linalg.eigvals(standard).real.sort(dim=1).values
    torch.testing.assert_close(ordered, torch.linalg.eigvalsh(symmetric), rtol=0, atol=1e-9)


def test_the_conformal_operator_is_as_the_paper_writes_it(truncated, fit):
    latent = fit(truncated(4, 20), 16, 8)
    Y, Lambda = latent.Y[2].numpy(), np.diag(latent.evals[2].numpy())
    spectrum = latent.spectrum.numpy()
    expected = np.diag([0, *1 / spectrum[1:]]) @ Y.T @ Lambda @ Y
    actual = conformal_difference(latent.Y[2], latent.evals[2], latent.spectrum)
    np.testing.assert_allclose(actual.numpy(), expected, atol=1e-12)


def test_the_pseudo_inverse_leaves_out_the_null_direction_only():
    values = torch.tensor([-1e-3, 200.0, 250.0, 0.1, 400.0], dtype=torch.float64)
    assert pseudo_inverse(values).tolist() == [0, 1 / 200, 1 / 250, 0, 1 / 400]
    assert pseudo_inverse(values[:1]).tolist() == [0]
    assert pseudo_inverse(torch.tensor([5.0, 200.0])).tolist() == [0, pytest.approx(1 / 200)]


def test_a_latent_function_comes_back_from_every_shape(truncated, fit):
    latent = fit(truncated(6, 30), 24, 16)
    alphas = np.random.default_rng(0).normal(size=(16, 3))
    for i in (0, 5):
        values = latent.to_shape(alphas, i)
        assert values.shape == (615, 3)
        np.testing.assert_allclose(latent.from_shape(values, i).numpy(), alphas, atol=1e-9)
        np.testing.assert_allclose(latent.to_shape(alphas[:, 0], i), values[:, 0], atol=1e-12)
        np.testing.assert_allclose(latent.from_shape(values[:, 0].numpy(), i).numpy(), alphas[:, 0], atol=1e-9)


def test_the_constant_of_the_latent_shape_is_the_constant_of_every_shape(truncated, fit):
    latent = fit(truncated(6, 40), 32, 10)
    values = latent.to_shape(np.eye(10)[0], 3)
    assert float(values.std() / values.mean().abs()) < 1e-2


def test_with_keep_is_the_fit_with_fewer_functions_kept(truncated, fit):
    whole, short = fit(truncated(6, 30), 24, 16), fit(truncated(6, 30), 24, 7)
    cut = whole.with_keep(7)
    for name in ("Y", "evals", "spectrum", "U", "energy"):
        torch.testing.assert_close(getattr(cut, name), getattr(short, name), rtol=0, atol=0)
    assert (len(cut), cut.keep, whole.keep) == (6, 7, 16)
    torch.testing.assert_close(cut.differences()[0], whole.differences()[0][:, :7, :7], rtol=0, atol=1e-14)
    for keep in (0, 17):
        with pytest.raises(InputError, match=f"keep={keep}: expected 1 to 16"):
            whole.with_keep(keep)


def test_float32_bases_give_the_operators_of_float64(truncated, fit, gauge):
    exact = fit(truncated(12, 80), 64, 40)
    single = [Eigenbasis(b.evals, b.evecs.astype(np.float32), b.mass, b.connectivity) for b in truncated(12, 80)]
    latent = fit(single, 64, 40)
    assert latent.Y.dtype == torch.float64
    area, conformal = exact.differences()
    area32, conformal32 = latent.differences()
    s = gauge(area, area32)
    assert float((s * area32 - area).abs().max()) < 1e-5
    assert float((s * conformal32 - conformal).abs().max()) < 1e-4


def test_sizes_have_defaults_and_borders(truncated, fit):
    latent = fit(truncated(3, 20))
    assert (latent.energy.shape, latent.keep) == ((16,), 10)
    assert fit(truncated(3, 20), 6).keep == 6
    with pytest.raises(InputError, match="size=21: expected 1 to 20, the number of eigenfunctions a shape"):
        fit(truncated(3, 20), 21)
    with pytest.raises(InputError, match="size=0: expected 1 to 20"):
        fit(truncated(3, 20), 0)
    with pytest.raises(InputError, match="keep=17: expected 1 to size=16"):
        fit(truncated(3, 20), 16, 17)
    with pytest.raises(InputError, match="keep=0: expected 1 to size=16"):
        fit(truncated(3, 20), 16, 0)
