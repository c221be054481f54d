"""Learning shapes from their operators: a cloud of points on each, or its vertices where all shapes correspond."""

from jaxtyping import Float
from torch import Tensor
from torch.nn import functional as F

from lssd_learn.learning.module import Learner
from lssd_learn.nets import chamfer


class Reconstruction(Learner):
    """Minimises the Chamfer distance between the clouds a net draws and those sampled from the shapes.

    Predictions are (n, N, 3), targets (n, M, 3), in metres; the score "cd" is in square metres. The search for nearest
    points uses as many threads as torch does.

    Source: paper, "Reconstruction".
    """

    names = ("cd",)
    predicts = "clouds"

    def scores(self, prediction: Float[Tensor, "n N 3"], target: Float[Tensor, "n M 3"]) -> tuple[Tensor]:
        return (chamfer(prediction, target),)


class VertexReconstruction(Learner):
    """Minimises the mean distance of vertices to the true ones; also says the mean squared error of a coordinate.

    Predictions and targets are (n, V, 3) in metres, of shapes in vertex correspondence.
    """

    names = ("vertex_error", "mse")
    predicts = "vertices"

    def scores(self, prediction: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        return (prediction - target).norm(dim=-1).mean(), F.mse_loss(prediction.detach(), target)

    def aims(self, target: Tensor) -> Tensor:
        return target.flatten(1)
