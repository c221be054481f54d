"""Learning which group a shape is of, the pose of a body in the paper, from its operators or its points."""

from typing import Any

import torch
from torch import Tensor
from torch.nn import functional as F

from lssd_learn.learning.module import Learner

WARM_UP = 60  # steps
LOGIT = 10.0  # what the right class of a training shape aims at, the others at zero: a probability of almost one


class Classification(Learner):
    """Minimises the cross entropy (nats) of a net with one output a class; also says the share it gets right.

    Targets are (n,) integers, 0 to the number of classes − 1. Predictions are logits; the largest is the answer.
    The learning rate rises over the first `WARM_UP` steps: started at once with that of the regression, the paper's
    CNN ends with all its ReLUs dead on some seeds.
    """

    names = ("cross_entropy", "accuracy")

    def loss(self, prediction: Tensor, target: Tensor) -> Tensor:
        return F.cross_entropy(prediction, target)

    def scores(self, prediction: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        right = prediction.detach().argmax(1) == target
        return F.cross_entropy(prediction, target), right.to(prediction).mean()

    def aims(self, target: Tensor) -> Tensor:
        return LOGIT * F.one_hot(target, self.hparams["outputs"]).double()

    def configure_optimizers(self) -> dict[str, Any]:
        adam = super().configure_optimizers()
        rise = torch.optim.lr_scheduler.LinearLR(adam, start_factor=1 / WARM_UP, total_iters=WARM_UP)
        return {"optimizer": adam, "lr_scheduler": {"scheduler": rise, "interval": "step"}}
