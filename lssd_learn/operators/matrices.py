"""The border of the room: what comes in as operators and functions, and the null functions of an operator.

Conformal operators annihilate the constant, and so have neither inverse nor logarithm. The rule of the whole room: a
function whose row vanishes in every operator at hand is null; logarithms, inverses and roots are taken on the other
functions, the live ones, and the row and column of a null function are zero in the result. Area operators have no null
functions. `nets.KernelMachine` asks here too.
"""

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.errors import InputError

# A row is null below this part of the largest entry.
NULL = 1e-6
# Below this part of the largest eigenvalue there is only the rounding of operators kept in float32.
SMALLEST = 1e-6
# The same for a matrix that should be symmetric, and for functions that should be orthonormal.
WRONG = 1e-4


def as_float64(values) -> Float[Tensor, "..."]:
    """A tensor, an array (read-only ones too) or plain numbers as a float64 tensor."""
    return values.double() if isinstance(values, Tensor) else torch.tensor(np.asarray(values, dtype=float))


def as_operators(name: str, D) -> Float[Tensor, "*s m m"]:
    """D (…, m, m), a tensor or an array, as a float64 tensor.

    Raises:
        InputError: not square matrices of finite numbers.
    """
    D = as_float64(D)
    if D.ndim < 2 or D.shape[-1] != D.shape[-2]:
        raise InputError(f"{name}: expected operators (…, m, m), got {tuple(D.shape)}")
    if not D.sum().isfinite() and not D.isfinite().all():  # the sum takes a fraction of the time, and may overflow
        raise InputError(f"{name}: expected finite numbers, got nan or infinity")
    return D


def as_like_operators(**operators) -> list[Tensor]:
    """Several operators (…, m, m) of one latent space, on the device of the first.

    Raises:
        InputError: as `as_operators`; or their sizes differ.
    """
    first, *others = (as_operators(name, D) for name, D in operators.items())
    for name, D in zip(list(operators)[1:], others, strict=True):
        if D.shape[-1] != first.shape[-1]:
            raise InputError(
                f"{name}: expected operators of {first.shape[-1]} functions as the others, got {D.shape[-1]}"
            )
    return [first, *(D.to(first) for D in others)]


def as_functions(F, like: Float[Tensor, "... m m"]) -> Float[Tensor, "m r"]:
    """F (m, r) with orthonormal columns, or one function (m,), as a tensor (m, r) beside the operators `like`.

    Raises:
        InputError: another shape, or FᵀF is not the identity.
    """
    F = as_float64(F).to(like)
    F = F[:, None] if F.ndim == 1 else F
    m = like.shape[-1]
    if F.ndim != 2 or len(F) != m:
        raise InputError(f"F: expected functions ({m}, r) on the latent shape of the operators, got {tuple(F.shape)}")
    if not ((F.T @ F - torch.eye(F.shape[1]).to(F)).abs() < WRONG).all():
        raise InputError("F: expected orthonormal functions, FᵀF = I")
    return F


def null_functions(*operators) -> Bool[Tensor, " m"]:
    """(m,) bool: the functions whose row vanishes in all the operators (…, m, m) given.

    Raises:
        InputError: not square matrices, or of different sizes.
    """
    operators = as_like_operators(**{f"operators[{i}]": D for i, D in enumerate(operators)})
    live = torch.zeros(operators[0].shape[-1], dtype=torch.bool, device=operators[0].device)
    for D in operators:
        if D.numel() == 0:  # of no shape at all there is nothing to leave out
            live[:] = True
            continue
        rows = D.abs().amax(-1).flatten(0, -2).amax(0) if D.ndim > 2 else D.abs().amax(-1)
        live |= rows > NULL * rows.max()
    return ~live


def restrict(D: Float[Tensor, "*s m m"], live: Bool[Tensor, " m"]) -> Float[Tensor, "*s l l"]:
    """The rows and columns (…, l, l) of the live functions (m,) bool."""
    return D[..., live, :][..., live]


def extend(D: Float[Tensor, "*s l l"], live: Bool[Tensor, " m"]) -> Float[Tensor, "*s m m"]:
    """Undo `restrict`: (…, l, l) → (…, m, m), zero on the null functions."""
    whole = D.new_zeros(*D.shape[:-2], len(live), len(live))
    index = live.nonzero().flatten()
    whole[..., index[:, None], index] = D
    return whole


def symmetric_eigh(
    name: str, D: Float[Tensor, "*s m m"], positive: bool = False
) -> tuple[Float[Tensor, "*s m"], Float[Tensor, "*s m m"]]:
    """Eigenvalues (…, m) ascending and eigenvectors (…, m, m) of symmetric, perhaps positive definite, operators.

    Raises:
        InputError: an operator that is not.
    """
    if positive and D.shape[-1] == 0:
        raise InputError(f"{name}: expected positive definite operators, got nothing but null functions")
    size = D.abs().amax((-2, -1)) if D.numel() else D.new_zeros(())
    if D.numel() and ((D - D.mT).abs().amax((-2, -1)) > WRONG * size).any():
        raise InputError(f"{name}: expected symmetric operators (of conformal ones take the symmetric form)")
    evals, V = torch.linalg.eigh((D + D.mT) / 2)
    if positive and (evals[..., :1] <= SMALLEST * evals[..., -1:].clamp(min=0)).any():
        raise InputError(
            f"{name}: expected positive definite operators, got an eigenvalue of {float(evals.min()):.2g} "
            f"beside a largest of {float(evals.max()):.2g}"
        )
    return evals, V
