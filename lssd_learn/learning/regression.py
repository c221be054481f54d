"""Learning numbers a shape, the body parameters in the paper, from its operators or its points."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.learning.module import Learner

# Deviation and middle of numbers drawn uniformly from [0, 1], as the paper's parameters are: what its learning rates
# are made for, and what a net whose output cannot be negative can give.
UNIFORM, MIDDLE = 12**-0.5, 0.5


class Regression(Learner):
    """Numbers of any unit: years, millimetres, thousandths train as numbers in [0, 1] do.

    The net sees every parameter shifted and scaled to the middle ½ and the deviation of the uniform distribution on
    [0, 1]; predictions and the scores "mse" and "l1" are in the parameters' own units, means over all entries.
    "relative_mse" is the mean over the parameters of mean squared error over training variance: predicting the training
    mean has about 1. It is what is minimised. Without standardisation ("raw", as in the paper) the net sees the
    parameters as they are and minimises "mse".
    """

    names = ("mse", "l1", "relative_mse")

    def __init__(self, net: nn.Module, learning_rate: float | None, mean: Tensor | None = None):
        super().__init__(net, learning_rate, mean)
        # Float64: a year has four digits before those that differ.
        self.register_buffer("centre", torch.zeros((), dtype=torch.float64))
        self.register_buffer("scale", torch.ones((), dtype=torch.float64))
        self.register_buffer("deviation", torch.ones((), dtype=torch.float64))

    @property
    def minimised(self) -> str:
        return "relative_mse" if self.scale.ndim else "mse"

    def adapt_to(self, targets: Float[Tensor, "n p"], standardised: bool = True) -> None:
        """Take middle and deviation (p,) of each parameter from the training targets (n, p); one that is constant keeps
        its unit."""
        targets = targets.double()
        deviation = targets.std(0, correction=0)
        self.deviation = torch.where(deviation > 0, deviation, 1.0)
        if standardised:
            self.scale = self.deviation / UNIFORM
            self.centre = targets.mean(0) - MIDDLE * self.scale

    def told(self, outputs: Float[Tensor, "n p"]) -> Float[Tensor, "n p"]:
        return self.centre + self.scale * outputs if self.scale.ndim else outputs

    def aims(self, target: Float[Tensor, "n p"]) -> Float[Tensor, "n p"]:
        return (target - self.centre) / self.scale if self.scale.ndim else target

    def loss(self, prediction: Float[Tensor, "n p"], target: Float[Tensor, "n p"]) -> Tensor:
        error = prediction - target
        return ((error / self.deviation) if self.scale.ndim else error).square().mean()

    def scores(self, prediction: Float[Tensor, "n p"], target: Float[Tensor, "n p"]) -> tuple[Tensor, Tensor, Tensor]:
        error = prediction - target
        return error.square().mean(), error.detach().abs().mean(), (error / self.deviation).square().mean()

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        super().on_load_checkpoint(checkpoint)
        # Only the checkpoint knows how many parameters there are; one from before they were standardised has none.
        state = checkpoint["state_dict"]
        for name in ("centre", "scale", "deviation"):
            setattr(self, name, state.setdefault(name, getattr(self, name)))
