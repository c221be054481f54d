"""The shapes of a learning task as tensors, split and batched: stands between the pipeline and the training."""

from dataclasses import replace

import lightning
import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from lssd_learn.division.split import Split
from lssd_learn.errors import InputError, check_whole
from lssd_learn.learning.batches import Batches, Epoch, Epochs, Order, Variation


class ShapeData(lightning.LightningDataModule):
    """Operators or clouds and what is to be learnt from them, all in memory.

    Inputs stay as they are given, in float32. What is to be subtracted from them is `mean`; the trained module holds
    it and subtracts it itself, so that it can be given any raw operator later.

    Args:
        inputs: (n, channels, m, m) operators or (n, points, 3) clouds; tensor, array or memory map.
        targets: (n, …) floats to regress, or (n,) integer labels.
        split: who is in which part, from `split(n, seed)`.
        seed: of the order of the training batches.
        batch: samples a training step, over all processes.
        standardise: "mean" subtracts the mean over the training split and scales nothing (paper, "Training details"),
            "none" leaves the inputs alone; "auto" is "mean" for operators and "none" for clouds.
        variation: what becomes of the training clouds, every epoch anew; None nothing.
        standardise_targets: whether the net sees the parameters of a regression in one scale, see `Regression`.
        blocks: (n,) numbers of the blocks that shapes belong to, for a net that rehearses; None nothing.

    Raises:
        InputError: arrays that do not fit each other or the split, or that are not finite.

    Attributes:
        inputs, targets: tensors, floats in float32 and labels in int64; parameters (n, p) in float64.
        mean: (channels, m, m), or () and zero if nothing is subtracted.
        channels, size: of one input, as the nets want them.
        outputs: numbers a net is to give: one a target, or one a class.
    """

    def __init__(
        self,
        inputs: ArrayLike,
        targets: ArrayLike,
        *,
        split: Split,
        seed: int,
        batch: int = 50,
        standardise: str = "auto",
        variation: Variation | None = None,
        standardise_targets: bool = True,
        blocks: np.ndarray | None = None,
    ):
        super().__init__()
        self.blocks = None if blocks is None else torch.from_numpy(np.asarray(blocks, dtype=np.int64))
        self.inputs, self.targets = _tensor(inputs, "inputs"), _tensor(targets, "targets")
        self.standardise_targets = standardise_targets
        if not standardise_targets and self.targets.is_floating_point():
            self.targets = self.targets.float()  # the arithmetic of the net, which sees them as they are
        self.split, self.seed, self.batch = split, seed, batch
        last = max(int(positions.max()) for _, positions in split.items())
        if not len(self.inputs) == len(self.targets) > last:
            what = f"{len(self.inputs)} inputs, {len(self.targets)} targets and a split that names shape {last}"
            raise InputError(f"{what} do not fit each other")
        check_whole("batch", batch, 1)
        check_whole("seed", seed, 0)
        shape = tuple(self.inputs.shape[1:])
        if len(shape) == 3 and shape[1] == shape[2]:
            self.channels, self.size = shape[:2]
        elif len(shape) == 2 and shape[1] == 3:
            self.size, self.channels = shape
        else:
            wanted = "(n, channels, m, m) operators or (n, points, 3) clouds"
            raise InputError(f"inputs must be {wanted}, got {tuple(self.inputs.shape)}")
        self.variation = None if variation is None else self._checked(variation)
        labels = not self.targets.is_floating_point()
        self.outputs = int(self.targets.max()) + 1 if labels else self.targets[0].numel()
        if standardise not in ("auto", "mean", "none"):
            raise InputError(f"standardise must be auto, mean or none, got {standardise!r}")
        subtract = standardise == "mean" or (standardise == "auto" and len(shape) == 3)
        self.by_epochs = False
        self.mean = self.part("train")[0].double().mean(0).float() if subtract else torch.zeros(())

    def part(self, name: str) -> tuple[Tensor, Tensor]:
        """Inputs and targets of "train", "test" or "validation"."""
        positions = torch.from_numpy(getattr(self.split, name))
        return self.inputs[positions], self.targets[positions]

    def train_dataloader(self) -> Batches | Epochs:
        return Epochs(self.training(), self.val_dataloader()) if self.by_epochs else self.training()

    def training(self) -> Batches:
        """The batches of the training split, in another order every epoch."""
        rank, world = (self.trainer.global_rank, self.trainer.world_size) if self.trainer else (0, 1)
        inputs, targets = self.part("train")
        vary = None if self.variation is None else self.variation.among(self.split.train)
        return Batches(Order(len(inputs), self.batch, self.seed, rank, world), inputs, targets, vary=vary)

    def val_dataloader(self) -> Batches:
        return self._in_order("validation")

    def test_dataloader(self) -> Batches:
        return self._in_order("test")

    def transfer_batch_to_device(
        self, batch: tuple[Tensor, ...] | Epoch, device: torch.device, dataloader_idx: int
    ) -> tuple[Tensor, ...] | Epoch:
        if isinstance(batch, Epoch):  # whose batches are made one by one
            return batch
        # Lightning's own is made for any nesting of containers and takes longer.
        return tuple(tensor.to(device) for tensor in batch)

    def _checked(self, variation: Variation) -> Variation:
        """The same with a tensor of denser clouds."""
        if self.inputs.ndim != 3:
            raise InputError(f"variation: expected clouds to vary, got inputs {tuple(self.inputs.shape)}")
        n, points, _ = self.inputs.shape
        if variation.up not in (None, "y", "z"):
            raise InputError(f"variation: expected y or z as the axis that is up, got {variation.up!r}")
        if variation.denser is None:
            return variation
        denser = _tensor(variation.denser, "denser clouds")
        shape = tuple(denser.shape)
        if len(shape) != 3 or shape[::2] != (n, 3) or shape[1] < points:
            raise InputError(f"variation: expected denser clouds ({n}, {points} or more, 3), got {shape}")
        return replace(variation, denser=denser)

    def _in_order(self, name: str) -> Batches:
        # Every process takes all of them: exact whatever their number, and cheaper than sharing out forty shapes.
        inputs, targets = self.part(name)
        return Batches(Order(len(inputs), self.batch), inputs, targets)


def _tensor(values: ArrayLike, what: str) -> Tensor:
    """A float32 or int64 copy, checked to be finite."""
    array = values.detach().cpu().numpy() if isinstance(values, Tensor) else np.asarray(values)
    if array.dtype.kind in "iu":
        return torch.tensor(array, dtype=torch.int64)
    if not np.isfinite(array).all():
        raise InputError(f"{what} must be finite, {np.count_nonzero(~np.isfinite(array))} values of them are not")
    # A year, or a place on earth, has digits before those that differ.
    return torch.tensor(array, dtype=torch.float64 if what == "targets" and array.ndim == 2 else torch.float32)
