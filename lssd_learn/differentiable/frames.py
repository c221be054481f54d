"""Eigenvectors and roots of small symmetric matrices, differentiable also where eigenvalues are equal.

Eigenvectors of equal eigenvalues are any basis of a subspace, and turn by any angle as soon as the matrix moves: they
have no derivative, the subspace has. So a cluster of eigenvalues comes as a frame of its subspace, that follows it
without turning within, and the matrix as it is in that frame, a block. Whatever does not depend on the choice of the
frame has its right gradient.
"""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.errors import InputError

# Eigenvalues nearer than this part of the larger one count as equal.
CLUSTER = 1e-6


def frame(
    A: Float[Tensor, "N N"], count: int, clusters: float = CLUSTER
) -> tuple[Float[Tensor, "N count"], Float[Tensor, "count count"]]:
    """Q (N, count), orthonormal, of the lowest eigenvalues of a symmetric A, and QᵀAQ (count, count).

    QᵀAQ is diagonal, and its derivative is so but for the blocks of clusters.

    Args:
        A: (N, N).
        count: 1 … N.
        clusters: eigenvalues nearer than this part of the larger one are equal; infinity makes one of them all.

    Raises:
        InputError: in the backward pass, where `count` cuts a cluster: there is no derivative.
    """
    return _Frame.apply(A, count, clusters)  # pyright: ignore[reportReturnType]


class _Frame(torch.autograd.Function):
    @staticmethod
    def forward(ctx, A, count, clusters):  # pyright: ignore[reportIncompatibleMethodOverride]
        evals, V = torch.linalg.eigh((A + A.mT) / 2)
        ctx.save_for_backward(evals, V)
        ctx.count, ctx.clusters = count, clusters
        return V[:, :count].clone(), evals[:count].diag()

    @staticmethod
    def backward(ctx, grad_Q, grad_form):  # pyright: ignore[reportIncompatibleMethodOverride]
        refuse_second("frame")
        evals, V = ctx.saved_tensors
        count = ctx.count
        check_gap(evals, count)
        same = same_cluster(evals, ctx.clusters, count)
        gaps = evals[None, :count] - evals[:, None]  # λ_j − λ_i, of dQ_j along v_i
        inner = V.mT @ grad_Q * torch.where(same, 0, 1 / torch.where(same, 1, gaps))
        inner[:count] += torch.where(same[:count], (grad_form + grad_form.mT) / 2, 0)
        grad = V @ inner @ V[:, :count].mT
        return (grad + grad.mT) / 2, None, None


def same_cluster(evals: Float[Tensor, " N"], clusters: float, count: int) -> Bool[Tensor, "N count"]:
    """Which of ascending eigenvalues (N,) are of one cluster; those from `count` on are of none with those before."""
    if clusters == float("inf"):
        number = torch.zeros(len(evals), dtype=torch.long, device=evals.device)
    else:
        number = (evals.diff(prepend=evals[:1]) > clusters * evals.abs()).cumsum(0)
    same = number[:, None] == number[None, :count]
    same[count:] = False
    return same


def check_gap(evals: Float[Tensor, " N"], count: int, name: str = "count") -> None:
    """Refuse to cut between equal eigenvalues.

    Raises:
        InputError: eigenvalues count and count + 1, ascending, are as good as equal.
    """
    if count < len(evals) and evals[count] - evals[count - 1] <= CLUSTER * evals[count].abs():
        raise InputError(
            f"{name}={count}: no derivative, eigenvalues {count} and {count + 1} are equal; expected a number that "
            "keeps them together"
        )


def refuse_second(name: str) -> None:
    """Of a backward pass of ours, called first: a graph of it would leave out what it does with arrays.

    Raises:
        InputError: it was called with create_graph=True.
    """
    if torch.is_grad_enabled():
        raise InputError(f"{name}: first derivatives only; expected a backward pass without create_graph=True")


def inverse_root(A: Float[Tensor, "m m"]) -> Float[Tensor, "m m"]:
    """A^-½ (m, m) of a symmetric positive definite A, with equal eigenvalues or without."""
    return _InverseRoot.apply(A)  # pyright: ignore[reportReturnType]


class _InverseRoot(torch.autograd.Function):
    @staticmethod
    def forward(ctx, A):  # pyright: ignore[reportIncompatibleMethodOverride]
        evals, V = torch.linalg.eigh((A + A.mT) / 2)
        ctx.save_for_backward(evals, V)
        return (V / evals.sqrt()) @ V.mT

    @staticmethod
    def backward(ctx, grad):  # pyright: ignore[reportIncompatibleMethodOverride]
        refuse_second("inverse_root")
        evals, V = ctx.saved_tensors
        s = evals.sqrt()
        slopes = -1 / (s[:, None] * s * (s[:, None] + s))  # divided differences of x^-½: no difference is divided by
        inner = V.mT @ ((grad + grad.mT) / 2) @ V * slopes
        return V @ inner @ V.mT
