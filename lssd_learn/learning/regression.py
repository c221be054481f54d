"""Learning numbers a shape, the body parameters in the paper, from its operators or its points."""

from torch import Tensor
from torch.nn import functional as F

from lssd_learn.learning.module import Learner


class Regression(Learner):
    """Minimises the mean squared error; also says the mean absolute error. Both over all entries of the targets."""

    names = ("mse", "l1")

    def scores(self, prediction: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        return F.mse_loss(prediction, target), F.l1_loss(prediction.detach(), target)
