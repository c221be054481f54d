"""What tests of training share: a net of no size, and callbacks that see or disturb a run."""

import functools

import lightning

from lssd_learn.nets import MLP

TINY = functools.partial(MLP, first=16, hidden=(16,))


def numbers(metrics):
    return {name: value for name, value in metrics.items() if name != "seconds/fit"}


class Quiet(lightning.Callback):
    """Asks for nothing, but Lightning calls it for every batch."""


class Record(lightning.Callback):
    """Validation error and weights of every epoch, and, if asked for, the end of the world after one."""

    def __init__(self, crash_after=None):
        self.values, self.weights, self.crash_after = [], [], crash_after

    def on_train_epoch_end(self, trainer, pl_module):
        self.values.append(float(trainer.callback_metrics["validation/relative_mse"]))
        self.weights.append({name: tensor.clone() for name, tensor in pl_module.state_dict().items()})
        if trainer.current_epoch + 1 == self.crash_after:
            raise ConnectionResetError("power cut")
