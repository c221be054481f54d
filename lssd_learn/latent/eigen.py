"""The lowest eigenvectors of a large symmetric operator known by its products (Knyazev 2001, LOBPCG)."""

from collections.abc import Callable

import torch
from torch import Tensor

Apply = Callable[[Tensor], Tensor]


def lowest_eigenpairs(
    apply: Apply, start: Tensor, wanted: int, precondition: Apply, scale: float, tolerance: float, most: int = 500
) -> tuple[Tensor, Tensor]:
    """The `wanted` lowest eigenpairs of a symmetric operator, from a start block that holds some guard vectors more.

    Every round minimises the Rayleigh quotient over the span of the iterate, its preconditioned residual and the last
    step, which is orthonormalised as a whole: slower than the textbook recurrence, but it does not break down.

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
        RuntimeError: no convergence.
    """
    b = start.shape[1]
    X = torch.linalg.qr(start)[0]
    AX = apply(X)
    values, rotation = torch.linalg.eigh(X.T @ AX)
    X, AX = X @ rotation, AX @ rotation
    P = X[:, :0]
    for _ in range(most):
        residual = AX - X * values
        norms = residual.norm(dim=0)
        open_columns = norms > tolerance * scale
        if not open_columns[:wanted].any():
            return values, X
        directions = torch.cat([precondition(residual[:, open_columns]), P], dim=1)
        for _ in range(2):  # twice is enough (Kahan)
            directions = directions - X @ (X.T @ directions)
            directions = directions / directions.norm(dim=0).clamp(min=torch.finfo(X.dtype).tiny)
        Z = torch.linalg.qr(directions)[0]
        Z = torch.linalg.qr(Z - X @ (X.T @ Z))[0]
        AZ = apply(Z)
        S, AS = torch.cat([X, Z], dim=1), torch.cat([AX, AZ], dim=1)
        T = S.T @ AS
        values, rotation = torch.linalg.eigh((T + T.T) / 2)
        values, rotation = values[:b], rotation[:, :b]
        X, AX = S @ rotation, AS @ rotation
        P = Z @ rotation[b:, :][:, open_columns]
    worst = float(norms[:wanted].max()) / scale
    raise RuntimeError(
        f"the consistent basis did not converge in {most} rounds: residual {worst:.1e}, asked {tolerance:.1e}"
    )
