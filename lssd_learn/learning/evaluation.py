"""What a trained module says of shapes, and its scores on the three parts of its data."""

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.module import Learner


@torch.no_grad()
def evaluate(learner: Learner, data: ShapeData) -> dict[str, float]:
    """Every score of `learner` on every part: "train/mse", "test/l1", …, the weights standing still.

    Runs where the module is, in its precision, in batches of `data.batch`, and adds up in float64.
    """
    learner.eval()
    metrics = {}
    for part, positions in data.split.items():
        inputs, targets = (tensor.split(data.batch) for tensor in data.part(part))
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
    return torch.cat([learner(some.to(learner.mean)) for some in inputs.split(batch)]).double().cpu().numpy()
