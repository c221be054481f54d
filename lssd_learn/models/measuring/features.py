"""What a reader of body measures knows a body by: the logarithms of its operators and, as they need no map, of its
frequencies."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.operators.vectors import live_functions, log_features


@dataclass(frozen=True)
class Features:
    """How features are made.

    Attributes:
        live: (channels, m) functions that no operator of the bodies it was made for is null on.
        weight: of the logarithms of frequencies, which then vary as much as all operators do together.
    """

    live: Bool[np.ndarray, "channels m"]
    weight: float

    @classmethod
    def of(cls, operators: Float[Tensor, "n channels m m"], evals: Float[Tensor, "n k"]) -> "Features":
        """Those that fit bodies with operators (n, channels, m, m) and frequencies (n, k)."""
        live = live_functions(operators)
        spreads = [some.var(0).sum().sqrt() for some in (log_features(operators.double(), live), _logarithms(evals))]
        return cls(live.numpy(), float(spreads[0] / spreads[1]))

    def __call__(
        self, operators: Float[Tensor, "n channels m m"], evals: Float[Tensor, "n k"]
    ) -> Float[np.ndarray, "n d"]:
        """(n, d) of n bodies."""
        logarithms = log_features(operators.double(), torch.from_numpy(self.live))
        return torch.cat([logarithms, self.weight * _logarithms(evals)], dim=1).numpy()


def _logarithms(evals: Tensor) -> Tensor:
    """(n, k - 1), without the constant's zero."""
    return evals[:, 1:].double().clamp(min=torch.finfo(torch.float64).tiny).log()
