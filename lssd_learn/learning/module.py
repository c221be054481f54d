"""What every training has in common: a net, scores of its predictions, Adam, and what is logged."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, cast

import lightning
import torch
from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.learning.batches import Epoch


class RunningMean:
    """Means over samples, from means over batches."""

    def __init__(self):
        self.total: Tensor | float = 0.0
        self.seen = 0

    def add(self, values: Tensor, n: int) -> None:
        self.total = self.total + n * values
        self.seen += n

    def take(self) -> Tensor:
        """The means so far; starts anew."""
        mean = self.total / self.seen
        self.__init__()
        return cast(Tensor, mean)


class Learner(lightning.LightningModule):
    """A net and the mean input it subtracts. A subclass says in `names` and `scores` what is learnt.

    Logged once an epoch: every score under train/ (a running mean while the weights move) and validation/.

    Args:
        net: the network.
        learning_rate: of Adam, β = (.9, .999); None for a net that is solved in closed form.
        mean: subtracted from every input; None for nothing.
    """

    # The scores; the first is the one that tells how good a run is.
    names: ClassVar[Sequence[str]]
    # prediction, target → the score that is minimised; None where it takes as long alone as with the others.
    loss: Callable[[Tensor, Tensor], Tensor] | None = None
    # What it wants of a net, see `lssd_learn.nets.writes`.
    predicts: ClassVar[str] = "numbers"

    def __init__(self, net: nn.Module, learning_rate: float | None, mean: Tensor | None = None):
        super().__init__()
        self.save_hyperparameters({"learning_rate": None if learning_rate is None else float(learning_rate)})
        self.net = net
        self.register_buffer("mean", torch.zeros(()) if mean is None else mean.clone())
        # Summed here and logged once an epoch: `self.log` in every step would take as long as the step.
        self._means = {part: RunningMean() for part in ("train", "validation", "test")}

    def __setattr__(self, name: str, value: Any) -> None:
        # Lightning notes the name of the hook here some three hundred times an epoch, and a Module's own way is slow.
        if name == "_current_fx_name":
            self.__dict__[name] = value
        else:
            super().__setattr__(name, value)

    @property
    def minimised(self) -> str:
        """The score that is minimised, and that the epoch is chosen by on the validation split."""
        return self.names[0]

    def scores(self, prediction: Tensor, target: Tensor) -> Sequence[Tensor]:
        """A mean over the batch for each of `names`."""
        raise NotImplementedError

    def adapt_to(self, targets: Tensor, standardised: bool = True) -> None:
        """Look at the training targets before the first step: at the units they are in.

        Args:
            targets: of the training split.
            standardised: whether the net is to see them in one scale, so that all count alike.
        """

    def told(self, outputs: Tensor) -> Tensor:
        """Predictions, in the units of the targets, out of what the net gives."""
        return outputs

    def aims(self, target: Tensor) -> Float[Tensor, "n outputs"]:
        """(n, outputs) numbers a net that is solved in closed form fits by least squares, in place of minimising a
        score: what it then gives is made a prediction by `told`."""
        return target

    def forward(self, inputs: Tensor) -> Tensor:
        """Predictions for raw inputs, as the pipeline made them."""
        return self.told(self.net(inputs - self.mean))

    def configure_optimizers(self) -> torch.optim.Optimizer:
        # One call for all weights: with nets of a dozen tensors, the calls are what a step of Adam costs.
        # It scales float16 gradients back by itself, and so after they would be clipped.
        clipped = self.trainer.precision == "16-mixed" and self.trainer.gradient_clip_val is not None
        return torch.optim.Adam(self.parameters(), lr=self.hparams["learning_rate"], fused=not clipped)

    def training_step(self, batch: tuple[Tensor, Tensor] | Epoch, index: int) -> Tensor | None:
        return self._epoch(batch) if isinstance(batch, Epoch) else self._step(batch, "train")

    def _epoch(self, epoch: Epoch) -> None:
        """All steps of an epoch and the validation after it, in what is one step to Lightning: its hooks take twice as
        long as a step of a small net. The weights are the same to the last bit."""
        optimizer = cast(torch.optim.Optimizer, self.optimizers(use_pl_optimizer=False))
        schedule = cast(torch.optim.lr_scheduler.LRScheduler | None, self.lr_schedulers())
        device, weights, seen = self.device, list(self.parameters()), []
        counted = self.trainer.fit_loop.epoch_loop.manual_optimization.optim_step_progress
        for inputs, target in epoch.training:
            inputs, target = inputs.to(device), target.to(device)
            if self.loss is None:
                loss = self._step((inputs, target), "train")
            else:
                prediction = self(inputs)
                loss = self.loss(prediction, target)
                seen.append((prediction.detach(), target))
            for weight in weights:
                weight.grad = None  # what `zero_grad` does, and takes a tenth of the step for
            loss.backward()
            optimizer.step()
            if schedule is not None:
                schedule.step()
            counted.increment_completed()  # which Lightning does itself where it wraps the optimiser
        self.eval()
        with torch.no_grad():
            if seen:  # the other scores, at once
                prediction, target = (torch.cat(tensors) for tensors in zip(*seen, strict=True))
                self._means["train"].add(torch.stack(list(self.scores(prediction, target))), len(target))
            for inputs, target in epoch.validation:
                self._step((inputs.to(device), target.to(device)), "validation")
        self.train()
        self._log("validation", "train")

    def validation_step(self, batch: tuple[Tensor, Tensor], index: int) -> None:
        self._step(batch, "validation")

    def test_step(self, batch: tuple[Tensor, Tensor], index: int) -> None:
        self._step(batch, "test")

    def on_train_epoch_end(self) -> None:
        if self.automatic_optimization:
            self._log("train")

    def on_validation_epoch_end(self) -> None:
        self._log("validation")

    def on_test_epoch_end(self) -> None:
        self.log_dict({f"test/{name}": value for name, value in self._scores("test").items()})

    def _step(self, batch: tuple[Tensor, Tensor], part: str) -> Tensor:
        inputs, target = batch
        scores = self.scores(self(inputs), target)
        self._means[part].add(torch.stack([score.detach() for score in scores]), len(inputs))
        return scores[self.names.index(self.minimised)]

    def _log(self, *parts: str) -> None:
        # What `self.log` does, where callbacks and logger look; its bookkeeping takes as long as a small net's epoch.
        values = {f"{part}/{name}": value for part in parts for name, value in self._scores(part).items()}
        self.trainer.callback_metrics.update(values)
        if self.logger is not None:
            self.logger.log_metrics({name: float(value) for name, value in values.items()}, self.current_epoch + 1)

    def _scores(self, part: str) -> dict[str, Tensor]:
        """Name → mean since the last call, over all processes."""
        means = self.trainer.strategy.reduce(self._means[part].take(), reduce_op="mean").cpu()
        return dict(zip(self.names, means, strict=True))

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        # Only the checkpoint knows the shape of the mean. Of what was trained in double precision the weights come back
        # in that of this module, and so does it.
        self.mean = checkpoint["state_dict"]["mean"].to(self.mean)
