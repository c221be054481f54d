"""What a trained module says of shapes, and its scores on the three parts of its data."""

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.module import Learner
from lssd_learn.nets import is_solved

SOLVED = 1024  # shapes at once of a net that is solved in closed form: what it holds ready, it makes for every batch


@torch.no_grad()
def evaluate(learner: Learner, data: ShapeData) -> dict[str, float]:
    """Every score of `learner` on every part: "train/mse", "test/l1", …, the weights standing still.

    Runs where the module is, in its precision, in batches of `data.batch`, and adds up in float64.
    """
    learner.eval()
    metrics = {}
    for part, positions in data.split.items():
        inputs, targets = (tensor.split(_together(learner, data.batch)) for tensor in data.part(part))
        totals = torch.zeros(len(learner.names), dtype=torch.float64)
        for x, y in zip(inputs, targets, strict=True):
            scores = learner.scores(learner(x.to(learner.mean)), y.to(learner.device))
            totals += len(x) * torch.stack(list(scores)).double().cpu()
        means = (totals / len(positions)).tolist()
        metrics |= {f"{part}/{name}": mean for name, mean in zip(learner.names, means, strict=True)}
    return metrics


@torch.no_grad()
def predict(learner: Learner, inputs: Float[Tensor, "n ..."], batch: int = 50) -> Float[np.ndarray, "n ..."]:
    """(n, …) float64 predictions, in the units of the targets, for raw inputs (n, …)."""
    learner.eval()
    some_by_some = inputs.split(_together(learner, batch))
    return torch.cat([learner(some.to(learner.mean)) for some in some_by_some]).double().cpu().numpy()


def _together(learner: Learner, batch: int) -> int:
    return max(batch, SOLVED) if is_solved(learner.net) else batch
