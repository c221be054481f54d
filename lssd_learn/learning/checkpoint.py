"""Reading what a training run has written: `best.ckpt` to use it, `last.ckpt` to go on with it."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from torch import nn

from lssd_learn.errors import InputError
from lssd_learn.latent.storage import read_checkpoint
from lssd_learn.learning.module import Learner
from lssd_learn.learning.regression import Regression


def read(path: str | Path) -> dict[str, Any]:
    """The checkpoint at `path`, on the CPU. Only tensors and plain containers are read, so any file may be tried.

    Raises:
        InputError: no such file, or not a checkpoint of this program.
    """
    checkpoint = read_checkpoint(path)
    if not isinstance(checkpoint, dict) or not {"state_dict", "hyper_parameters", "epoch"} <= checkpoint.keys():
        raise InputError(f"{path} is not a checkpoint of a training run")
    return checkpoint


def restore(learner: Learner, checkpoint: dict[str, Any], path: str | Path) -> None:
    """Give `learner` the weights of `checkpoint`.

    Raises:
        InputError: the weights are those of another net, or of one for other inputs or outputs.
    """
    theirs, ours = (_what(hparams) for hparams in (checkpoint["hyper_parameters"], learner.hparams))
    if ours and theirs != ours:
        raise InputError(f"{path}: expected a net that reads {ours}, this one reads {theirs}")
    try:
        learner.on_load_checkpoint(checkpoint)
        learner.load_state_dict(checkpoint["state_dict"])
    except (KeyError, RuntimeError):
        raise InputError(f"{path} holds the weights of another net than this {type(learner.net).__name__}") from None


def _what(hparams: Mapping[str, Any]) -> str:
    """What a net reads and gives, in words; nothing for one that was not built for its data."""
    if not {"channels", "size", "outputs"} <= hparams.keys():
        return ""
    return f"inputs of size {hparams['size']} with {hparams['channels']} channels, for {hparams['outputs']} outputs"


def load(path: str | Path, net: nn.Module | Callable[..., nn.Module], module: type[Learner] = Regression) -> Learner:
    """A trained module from `best.ckpt`, ready to be called on raw inputs.

    Args:
        path: the file.
        net: a net, or its class (or `functools.partial`), which is then built for the inputs it was trained on.
        module: what it was trained as.

    Raises:
        InputError: not a checkpoint, or one of another net.
    """
    checkpoint = read(path)
    given = checkpoint["hyper_parameters"]
    if not isinstance(net, nn.Module):
        net = net(channels=given["channels"], size=given["size"], outputs=given["outputs"])
    learner = module(net, given["learning_rate"])
    restore(learner, checkpoint, path)
    return learner.eval()
