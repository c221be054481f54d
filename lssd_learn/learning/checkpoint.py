"""Reading what a training run has written: `best.ckpt` to use it, `last.ckpt` to go on with it."""

import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import nn

from lssd_learn.errors import InputError
from lssd_learn.learning.module import Learner
from lssd_learn.learning.regression import Regression


def read(path: str | Path) -> dict[str, Any]:
    """The checkpoint at `path`, on the CPU. Only tensors and plain containers are read, so any file may be tried.

    Raises:
        InputError: no such file, or not a checkpoint of this program.
    """
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except FileNotFoundError:
        raise InputError(f"no checkpoint at {path}") from None
    except (OSError, EOFError, RuntimeError, pickle.UnpicklingError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is not a readable checkpoint: {str(error).splitlines()[0]}") from None
    if not isinstance(checkpoint, dict) or not {"state_dict", "hyper_parameters", "epoch"} <= checkpoint.keys():
        raise InputError(f"{path} is not a checkpoint of a training run")
    return checkpoint


def restore(learner: Learner, checkpoint: dict[str, Any], path: str | Path) -> None:
    """Give `learner` the weights of `checkpoint`.

    Raises:
        InputError: the weights are those of another net.
    """
    try:
        learner.on_load_checkpoint(checkpoint)
        learner.load_state_dict(checkpoint["state_dict"])
    except (KeyError, RuntimeError):
        raise InputError(f"{path} holds the weights of another net than this {type(learner.net).__name__}") from None


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
