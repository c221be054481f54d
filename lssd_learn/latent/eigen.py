"""The lowest eigenvectors of a large symmetric operator known by its products (Knyazev 2001, LOBPCG)."""

import logging
import time
from collections.abc import Callable, Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.progress import LINE

log = logging.getLogger(__name__)

Apply = Callable[[Tensor], Tensor]

# Rounds over which the eigenvalues are watched, the relative change at which they have settled, and the part of the
# largest one carried from which an eigenvalue counts as one of the cluster that is cut.
WATCHED, SETTLED, CLUSTER = 10, 1e-3, 0.5
# At least as many eigenvectors are carried beyond those wanted, and k in all: they settle clusters of nearly equal
# eigenvalues at the cut-off. Energies grow fast with frequency, so that a narrower block would converge slowly.
GUARDS = 16
# A direction whose squared length is below this has nothing in it that is not in the others.
NEGLIGIBLE = 1e-12


def lowest_eigenpairs(
    apply: Apply,
    start: Float[Tensor, "N b"],
    wanted: int,
    precondition: Apply,
    scale: float,
    tolerance: float,
    most: int = 400,
) -> tuple[Float[Tensor, " b"], Float[Tensor, "N b"]]:
    """The `wanted` lowest eigenpairs of a symmetric operator, from a start block that holds some guard vectors more.

    Every round minimises the Rayleigh quotient over the span of the iterate, its preconditioned residual and the last
    step. The step is made orthonormal to the iterate in their coefficients (Duersch, Shao, Yang & Gu 2018), so that its
    product with the operator is known and only residuals are multiplied; these are then made orthonormal to both.

    Sparse networks have clusters of nearly equal eigenvalues, copies of one function that vary slowly over the graph.
    Where such a cluster is cut, its vectors are not unique and their residuals hardly fall; if the eigenvalues have
    settled by then, any of them serves, and the log says so.

    Args:
        apply: the operator on (N, m) blocks.
        start: (N, b) with b ≥ wanted.
        wanted: number of pairs to converge.
        precondition: an approximate inverse of the operator on (N, m) blocks.
        scale: the operator's norm, which residuals are compared with.
        tolerance: ‖W x − λ x‖ ≤ tolerance · scale.
        most: rounds allowed.

    Returns:
        eigenvalues (b,), ascending, and orthonormal vectors (N, b); the first `wanted` have converged.

    Raises:
        RuntimeError: neither the vectors have converged nor the eigenvalues settled.
    """
    b = start.shape[1]
    X = torch.linalg.qr(start)[0]
    AX = apply(X)
    values, rotation = torch.linalg.eigh(X.T @ AX)
    X, AX = X @ rotation, AX @ rotation
    P, AP = X[:, :0], X[:, :0]
    form = values.diag()  # of the operator on X and P
    history = []
    told = time.monotonic()
    for turn in range(most):
        residual = torch.addcmul(AX, X, values, value=-1)
        norms = residual.norm(dim=0)
        open_columns = norms > tolerance * scale
        history.append(values[:wanted])
        if not open_columns[:wanted].any():
            return values, X
        if time.monotonic() - told > LINE:
            told, worst = time.monotonic(), float(norms[:wanted].max()) / scale
            log.info("consistent basis: round %d, residual %.1e, wanted %.1e", turn, worst, tolerance)
        Z = _orthonormal(precondition(residual[:, open_columns]), (X, P))
        del residual  # of many shapes each is large
        AZ = apply(Z)
        across = torch.cat([X.T @ AZ, P.T @ AZ])
        form = torch.cat([torch.cat([form, across], dim=1), torch.cat([across.T, Z.T @ AZ], dim=1)])
        values, rotation = torch.linalg.eigh((form + form.T) / 2)
        values, rotation = values[:b], rotation[:, :b]
        step = rotation[:, open_columns].clone()
        step[:b] = 0
        both = torch.cat([rotation, _orthonormal(step, (rotation,))], dim=1)
        widths = [b, both.shape[1] - b]
        X, P = _combined((X, P, Z), both).split(widths, 1)
        AX, AP = _combined((AX, AP, AZ), both).split(widths, 1)
        form = both.T @ form @ both
    worst = float(norms[:wanted].max()) / scale
    if len(history) > WATCHED:
        now, cut = history[-1], open_columns[:wanted]
        settled = history[-1 - WATCHED] - now <= SETTLED * now.abs() + tolerance * scale
        if settled.all() and now[cut].min() >= CLUSTER * values[-1]:
            log.warning(
                "%d of %d consistent functions lie in a cluster that is cut: not unique", int(cut.sum()), wanted
            )
            return values, X
    raise RuntimeError(
        f"the consistent basis did not converge in {most} rounds: residual {worst:.1e}, asked {tolerance:.1e}"
    )


def _orthonormal(directions: Tensor, others: Sequence[Tensor]) -> Tensor:
    """Orthonormal columns that span `directions` (N, m) less what orthonormal others span; fewer where some are lost.

    By the Gram matrix (Stathopoulos & Wu 2002), twice over: products of matrices, where a QR would go column by column.
    The directions are written over: of many shapes room that is taken anew costs as much as what is done in it.
    """
    for _ in range(2):
        for other in others:
            directions.addmm_(other, other.T @ directions, alpha=-1)
        gram = directions.T @ directions
        lengths = gram.diagonal().clamp(min=torch.finfo(gram.dtype).tiny).rsqrt()
        squares, V = torch.linalg.eigh(lengths[:, None] * gram * lengths)
        sound = squares > NEGLIGIBLE
        directions = directions @ (lengths[:, None] * V[:, sound] / squares[sound].sqrt())
    return directions


def _combined(parts: Sequence[Tensor], coefficients: Tensor) -> Tensor:
    """[parts side by side] @ coefficients, without putting them there."""
    first, *others = zip(parts, coefficients.split([part.shape[1] for part in parts]), strict=True)
    total = first[0] @ first[1]
    for part, rows in others:
        total.addmm_(part, rows)
    return total


def block_inverse(blocks: Tensor, shift: float = 0.0) -> Apply:
    """Y (n·k, m) → the inverse of the block diagonal operator of `blocks` (n, k, k) + shift·I, applied to it."""
    n, k, _ = blocks.shape
    inverse = torch.linalg.inv(blocks + shift * torch.eye(k).to(blocks))
    return lambda Y: (inverse @ Y.view(n, k, -1)).flatten(0, 1)
