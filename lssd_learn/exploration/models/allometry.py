"""Shape along a number: one score a shape for it, and operators from which it is taken out.

Source: Drake & Klingenberg, "The pace of morphological change", Proceedings of the Royal Society B 275 (2008), for the
regression score.
"""

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.exploration.models.design import ModelDesign
from lssd_learn.operators.logarithms import exponential, logarithm
from lssd_learn.operators.matrices import null_functions


def regression_scores(Y: Float[np.ndarray, "n r"], design: ModelDesign) -> dict[str, Float[np.ndarray, " n"]]:
    """Of each number of a formula Yb / ‖b‖ (n,), with b the slope beside all else: how far a shape is along it.

    Args:
        Y: vectors about their mean.
        design: of the n shapes.
    """
    B, found = np.linalg.pinv(design.X) @ Y, {}
    for number in design.numbers:
        slope = (design.slope_rows(number, [], [()]) @ B)[0]
        if np.linalg.norm(slope) > 0:
            found[number] = Y @ slope / np.linalg.norm(slope)
    return found


def ensure_number(design: ModelDesign, number: str) -> None:
    """Refuse what is not one of the numbers of a formula.

    Raises:
        InputError: names those that there are.
    """
    if number not in design.numbers:
        known = ", ".join(design.numbers) or "none"
        raise InputError(f"task.without={number}: expected a number of the formula, it has {known}")


def without(operators: Float[Tensor, "n m m"], design: ModelDesign, number: str) -> Float[Tensor, "n m m"]:
    """Operators as they would be if a number were at its mean for all shapes: exp(log D_i − what the model adds).

    With an interaction each group has its own slope, without all have one.

    Args:
        operators: of n shapes, positive definite on the functions that are not null.
        design: of them.
        number: one of its numbers, as log(size).

    Raises:
        InputError: as `ensure_number`.
    """
    ensure_number(design, number)
    null = null_functions(operators)
    logs = logarithm(operators, null)
    added = (design.X - design.held(number)) @ np.linalg.pinv(design.X)
    moved = logs - torch.einsum("ij,jab->iab", torch.from_numpy(added).to(logs), logs)
    return exponential((moved + moved.mT) / 2, null)
