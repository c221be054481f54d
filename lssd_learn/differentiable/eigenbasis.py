"""The eigenbasis of a mesh as a function of its vertices: implicit derivatives of LΦ = MΦΛ."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable.complement import solve_complement
from lssd_learn.differentiable.forms import cotangents, vertex_masses
from lssd_learn.differentiable.frames import CLUSTER, check_gap, refuse_second, same_cluster
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.eigenbasis import eigenbasis_as_is
from lssd_learn.shapes.laplacian import cotangent


@dataclass(frozen=True, eq=False)
class Basis:
    """Eigenfunctions of a mesh of V vertices, or of several of the same faces (…).

    Attributes:
        evecs: Φ (…, V, k), ΦᵀMΦ = I.
        form: ΦᵀLΦ (…, k, k): the eigenvalues on the diagonal, and zeros, that are not constant within clusters. What
            is computed of it and of `evecs` has the right gradient if no rotation within a cluster changes it.
        mass: (…, V).
        vertices: (…, V, 3), the mesh itself.
    """

    evecs: Float[Tensor, "*s V k"]
    form: Float[Tensor, "*s k k"]
    mass: Float[Tensor, "*s V"]
    vertices: Float[Tensor, "*s V 3"]

    @property
    def evals(self) -> Float[Tensor, "*s k"]:
        """(…, k) ascending. Of a cluster only symmetric functions, as their sum, have a gradient."""
        return self.form.diagonal(dim1=-2, dim2=-1)

    def __getitem__(self, i) -> "Basis":
        """One of several, or some."""
        return Basis(self.evecs[i], self.form[i], self.mass[i], self.vertices[i])

    def __len__(self) -> int:
        """Of several bases, how many."""
        return len(self.evecs) if self.evecs.ndim > 2 else 1

    def __iter__(self) -> Iterator["Basis"]:
        """One after the other."""
        return (self[i] for i in range(len(self)))


def eigenbasis(
    vertices: Float[Tensor, "*s V 3"], faces: Int[Tensor, "F 3"], k: int, clusters: float = CLUSTER, pieces: int = 1
) -> Basis:
    """The k eigenfunctions of lowest frequency of a mesh, `shapes.eigenbasis` with gradients to the vertices.

    The cotangent Laplacian; computed in float64 on the processor, and given back in the type and on the device of the
    vertices. The backward pass solves for the part of each derivative off the k functions, by eight factorisations and
    a few rounds of conjugate gradients. First derivatives only: a second one is refused.

    Args:
        vertices: (V, 3), or a batch (…, V, 3), of one connectivity.
        faces: (F, 3).
        k: 1 … V − 1.
        clusters: eigenvalues nearer than this part of the larger one count as equal, see `Basis.form`. Infinity takes
            all k as one: right for what only depends on their span, as maps, latent bases and operators do.
        pieces: of how many connected pieces the mesh is.

    Raises:
        InputError: no vertices and faces of a mesh, no floating point numbers; what `shapes.eigenbasis` refuses; in
            the backward pass, k between two equal eigenvalues.
    """
    if not isinstance(vertices, Tensor) or not vertices.is_floating_point() or vertices.shape[-1:] != (3,):
        raise InputError("vertices: expected a tensor of floating point numbers (…, V, 3) of a mesh; clouds and the "
                         "robust Laplacian are not differentiable here")  # fmt: skip
    if vertices.ndim > 2:
        every = [eigenbasis(x, faces, k, clusters, pieces) for x in vertices]
        names = ("evecs", "form", "mass", "vertices")
        return Basis(*(torch.stack([getattr(one, name) for one in every]) for name in names))
    faces = torch.as_tensor(faces).to(vertices.device)
    evecs, form = _Lowest.apply(vertices, faces, k, pieces)  # pyright: ignore[reportGeneralTypeIssues]
    basis = Basis(evecs, form, vertex_masses(vertices, faces), vertices)
    return basis if clusters == float("inf") else _apart(basis, clusters)


def _apart(basis: Basis, clusters: float) -> Basis:
    """Each function's own derivative within the span of the k, where its eigenvalue is of no cluster with another's.

    dΦ along φ_i of φ_j is dΛ_ij / (λ_j − λ_i): Φ times a matrix whose value is the identity.
    """
    evals = basis.evals.detach()
    same = same_cluster(evals, clusters, len(evals))
    inverse = torch.where(same, 0, 1 / torch.where(same, 1, evals - evals[:, None]))
    turn = torch.eye(len(evals)).to(evals) + inverse * basis.form
    return replace(basis, evecs=basis.evecs @ turn, form=torch.where(same, basis.form, 0))


class _Lowest(torch.autograd.Function):
    """Φ and ΦᵀLΦ of the span of the k lowest functions, in a frame that follows it without turning.

    With Z the part of dΦ off the span, dΦ = −½ Φ (Φᵀ dM Φ) + Z and (L − λ_j M) z_j = −(dL − λ_j dM) φ_j there: no
    difference of two of the k eigenvalues is divided by.
    """

    @staticmethod
    def forward(ctx, vertices, faces, k, pieces):  # pyright: ignore[reportIncompatibleMethodOverride]
        mesh = Mesh(vertices.detach().cpu().double().numpy(), faces.cpu().numpy(), pieces)
        more = min(k + 1, len(mesh.vertices) - 1)  # the next one, to see whether there is a gap
        basis = eigenbasis_as_is(mesh, max(k, more), "cotangent")
        evals, evecs = (torch.tensor(np.ascontiguousarray(x)) for x in (basis.evals, basis.evecs[:, :k]))
        ctx.save_for_backward(vertices, faces, evals, evecs)
        return evecs.to(vertices), evals[:k].diag().to(vertices)

    @staticmethod
    def backward(ctx, grad_evecs, grad_form):  # pyright: ignore[reportIncompatibleMethodOverride]
        refuse_second("eigenbasis")
        vertices, faces, evals, Phi = ctx.saved_tensors
        k = Phi.shape[1]
        check_gap(evals, k, "k")
        evals = evals[:k]
        G, H = grad_evecs.cpu().double(), grad_form.cpu().double()
        H = (H + H.mT) / 2
        X, F = vertices.detach().cpu().double(), faces.cpu()
        L, M = cotangent(Mesh(X.numpy(), F.numpy()))
        Y = torch.from_numpy(solve_complement(L, M, evals.numpy(), Phi.numpy(), G.numpy()))
        S = Phi.mT @ G
        S = (S + S.mT) / 2 + H * evals + evals[:, None] * H
        # What is left is ⟨dL, AΦᵀ⟩ + ⟨dM, BΦᵀ⟩: sums over corners and vertices.
        A, B = Phi @ H - Y, Y * evals - Phi @ S / 2
        corners = torch.stack([_energies(A, Phi, F[:, (c + 1) % 3], F[:, (c + 2) % 3]) for c in range(3)], dim=1)
        with torch.enable_grad():
            X.requires_grad_()
            total = (cotangents(X, F) * corners).sum() / 2 + vertex_masses(X, F) @ (B * Phi).sum(1)
            grad = torch.autograd.grad(total, X)[0]
        return grad.to(vertices), None, None, None


def _energies(A: Tensor, Phi: Tensor, i: Tensor, j: Tensor) -> Tensor:
    """Σ (a_i − a_j)(φ_i − φ_j) over the columns, an edge a row."""
    return ((A[i] - A[j]) * (Phi[i] - Phi[j])).sum(1)
