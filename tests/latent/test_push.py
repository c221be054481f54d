"""A shape that was not fitted: how near its pushed operator comes to what a fit would have given it.

Errors are relative to the collection's spread, the root mean square of ‖D_j − I‖ (I is the mean of all D_j).
"""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, push_least_squares, push_nearest
from lssd_learn.maps import from_correspondence

METHODS = ["least_squares", "nearest"]


def spread(area):
    return (area - torch.eye(area.shape[1], dtype=area.dtype)).square().sum((1, 2)).mean().sqrt()


def push(latent, bases, new, neighbours, method="least_squares"):
    """A shape pushed from some that were fitted; `bases` are those of the latent space."""
    maps = {i: (from_correspondence(bases[i], new), from_correspondence(new, bases[i])) for i in neighbours}
    return latent.push(new, maps, method)


@pytest.fixture(scope="module")
def forty(many_bodies):
    """40 bodies, 80 eigenfunctions, 40 kept."""
    return many_bodies[:40], LatentSpace.fit(MapNetwork.clique(many_bodies[:40]), 64, 40)


def test_from_five_neighbours_within_two_per_cent_from_one_within_six(forty):
    """Each body pushed within the space it was fitted in, its own latent basis not used: the language is the same."""
    bases, latent = forty
    area, _ = latent.differences()
    errors = {(5, "least_squares"): [], (1, "least_squares"): [], (1, "nearest"): []}
    for k, basis in enumerate(bases):
        near = [i for i in latent.neighbours(basis.evals, 6) if i != k]
        for p, method in errors:
            pushed = push(latent, bases, basis, near[:p], method).area
            errors[p, method].append(float((pushed - area[k]).norm() / spread(area)))
    assert max(errors[5, "least_squares"]) < 0.02
    assert max(errors[1, "least_squares"]) < 0.06
    assert np.mean(errors[5, "least_squares"]) < np.mean(errors[1, "least_squares"])
    assert np.mean(errors[1, "least_squares"]) < 0.5 * np.mean(errors[1, "nearest"])


@pytest.mark.slow
def test_bodies_left_out_of_the_fit_come_as_near_on_average(forty):
    """The reference is the fit of all 40, expressed in the latent functions of the 39 by the best change of basis.

    An orthogonal one would not do: one body more moves the average shape, and with it what the identity means, by
    ‖D − I‖ / n; that is 2 to 4 % of the spread here and no fault of the push.
    """
    bases, whole = forty
    area, _ = whole.differences()
    errors = {5: [], 1: []}
    for left_out in (5, 16, 27, 38):
        same = [i for i in range(40) if i != left_out]
        rest, new = [bases[i] for i in same], bases[left_out]
        latent = LatentSpace.fit(MapNetwork.clique(rest), 64, 40)
        change = torch.linalg.lstsq(whole.Y[same].flatten(0, 1), latent.Y.flatten(0, 1)).solution
        expected = change.T @ area[left_out] @ change
        for p in errors:
            pushed = push(latent, rest, new, latent.neighbours(new.evals, p))
            errors[p].append(float((pushed.area - expected).norm() / spread(area)))
    assert np.mean(errors[5]) < 0.02
    assert np.mean(errors[1]) < 0.06


def test_a_body_left_out_of_a_larger_fit_needs_only_an_orthogonal_alignment(many_bodies):
    """Of 120 bodies one more moves the average shape by less than a hundredth of the spread."""
    whole = LatentSpace.fit(MapNetwork.clique(many_bodies[:]), 64, 40)
    latent = LatentSpace.fit(MapNetwork.clique(many_bodies[:-1]), 64, 40)
    U, _, Vt = torch.linalg.svd(whole.Y[:-1].flatten(0, 1).T @ latent.Y.flatten(0, 1))
    area, _ = whole.differences()
    expected = (U @ Vt).T @ area[-1] @ (U @ Vt)
    new = many_bodies[-1]
    for p, most in ((5, 0.02), (1, 0.06)):
        pushed = push(latent, many_bodies, new, latent.neighbours(new.evals, p))
        error = float((pushed.area - expected).norm() / spread(area))
        assert error < most


def test_the_papers_push_loses_what_its_map_loses(forty):
    """Its operators are too small; least squares repairs that."""
    bases, latent = forty
    ratios = {method: [] for method in METHODS}
    for k in range(0, 40, 4):
        near = [i for i in latent.neighbours(bases[k].evals, 2) if i != k][:1]
        for method in METHODS:
            own = latent.basis(k).square().sum()
            ratios[method].append(float(push(latent, bases, bases[k], near, method).area.trace() / own))
    assert max(ratios["nearest"]) < 1
    assert abs(np.mean(ratios["least_squares"]) - 1) < 0.2 * abs(np.mean(ratios["nearest"]) - 1)


@pytest.mark.parametrize("method", METHODS)
def test_with_a_full_basis_nothing_is_lost(deformed_spheres, full_basis, average, method):
    meshes = deformed_spheres(6, 1)
    bases = [full_basis(mesh) for mesh in meshes]
    latent = LatentSpace.fit(MapNetwork.clique(bases[:5]), 42, 42)
    pushed = push(latent, bases, bases[5], [3, 1], method)
    Phi = latent.to_shape(np.eye(42), 0).numpy()  # the average shape's eigenfunctions, of the latent signs
    _, _, Ls, Ms = average(meshes, 42)
    np.testing.assert_allclose(bases[5].evecs @ pushed.basis.numpy(), Phi, atol=1e-7)
    np.testing.assert_allclose(pushed.area.numpy(), Phi.T @ (Ms[5][:, None] * Phi), atol=1e-7)
    energy = latent.spectrum.numpy()[:, None] * pushed.differences()[1].numpy()
    np.testing.assert_allclose(energy, Phi.T @ Ls[5] @ Phi, atol=1e-6)


def test_least_squares_is_the_least_squares_solution():
    rng = np.random.default_rng(0)
    p, k, k_new, m = 3, 6, 5, 4
    Ys, there, back = rng.normal(size=(p, k, m)), rng.normal(size=(p, k_new, k)), rng.normal(size=(p, k, k_new))
    left = np.concatenate([np.eye(k_new)] * p + list(back))
    right = np.concatenate([C @ Y for C, Y in zip(there, Ys, strict=True)] + list(Ys))
    expected = np.linalg.lstsq(left, right)[0]
    found = push_least_squares(*(list(map(torch.from_numpy, x)) for x in (Ys, there, back)))
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-12)
    nearest = push_nearest(torch.from_numpy(Ys[0]), torch.from_numpy(there[0]))
    np.testing.assert_allclose(nearest.numpy(), there[0] @ Ys[0], atol=1e-12)


def test_the_papers_push_uses_the_first_neighbour_alone(forty):
    bases, latent = forty
    one, two = (push(latent, bases, bases[0], near, "nearest") for near in ([7], [7, 9]))
    assert torch.equal(one.area, two.area)


@pytest.mark.parametrize("method", METHODS)
def test_the_sign_of_the_new_eigenfunctions_does_not_matter(forty, method):
    bases, latent = forty
    flipped = replace(bases[0], evecs=bases[0].evecs * np.random.default_rng(0).choice([-1, 1], 80))
    a, b = (push(latent, bases, new, [7, 9], method) for new in (bases[0], flipped))
    torch.testing.assert_close(a.area, b.area, rtol=0, atol=1e-10)
    torch.testing.assert_close(a.conformal, b.conformal, rtol=0, atol=1e-9)


def test_neighbours_are_the_nearest_spectra(forty):
    bases, latent = forty
    evals = np.stack([b.evals for b in bases])
    for k in (0, 11):
        order = np.argsort(np.linalg.norm(evals - evals[k], axis=1))
        assert latent.neighbours(bases[k].evals) == order[:5].tolist()
        assert latent.neighbours(torch.from_numpy(evals[k]), 1) == [k]
    assert sorted(latent.neighbours(evals[0], 99)) == list(range(40))


def test_impossible_pushes_are_refused(forty):
    bases, latent = forty
    with pytest.raises(InputError, match="push: expected maps and least_squares or nearest, got 0 maps"):
        latent.push(bases[0], {})
    with pytest.raises(InputError, match="got 1 maps and 'farthest'"):
        latent.push(bases[0], {3: (np.eye(80), np.eye(80))}, "farthest")
