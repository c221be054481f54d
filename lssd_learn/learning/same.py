"""Whether a training run that goes on is the one that was begun: what it is made with, told and compared.

A checkpoint that goes on with another split trains on what is then called test; with another learning rate it goes on
with the old one and says the new. Neither would show in the numbers.
"""

import logging
from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.module import Learner

log = logging.getLogger(__name__)

MADE_WITH = "made_with"  # the entry of a checkpoint


def made_with(
    learner: Learner, data: ShapeData, learning_rate: float | None, seed: int, given: Mapping[str, Any]
) -> dict[str, Any]:
    """Name → value, plain, of all that the weights of a run depend on, epochs apart.

    Args:
        given: what the caller has chosen, by the names its user knows; may name some of the same settings.
    """
    split = torch.cat([torch.from_numpy(positions) for _, positions in data.split.items()])
    parts = ", ".join(f"{len(positions)} {name}" for name, positions in data.split.items())
    net = f"{type(learner.net).__name__} {_short(str(learner.net))}"
    known = {name.rpartition(".")[2] for name in given}
    settings = {"learning_rate": learning_rate, "batch": data.batch, "seed": seed, "net": net}
    return {
        **given,
        **{name: value for name, value in settings.items() if name not in known},
        # What the files hold is compared whatever is chosen: `data.targets` is a choice, and says nothing of labels.
        "split": f"{parts}, {_short(split)}",
        "targets": _described(data.targets),
        "inputs": _described(data.inputs),
        "subtracted mean": _described(data.mean),
    }


def check_same(path: str | Path, checkpoint: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Refuse to go on with what differs from the run that wrote a checkpoint.

    Args:
        path: of the checkpoint, for the message.
        now: what the run is made with, or a part of it.

    Raises:
        InputError: names all that differs, then and now.
    """
    then = checkpoint.get(MADE_WITH)
    if then is None:
        log.warning(
            "%s does not say what it was made with; that split, targets and net are the same is taken on trust", path
        )
        return
    differing = [
        f"{name} was {_said(then[name])}, now {_said(now[name])}"
        for name in now
        if name in then and then[name] != now[name]
    ]
    if differing:
        raise InputError(
            f"ckpt_path={path}: expected what it was made with, but {'; '.join(differing)}; give the former, or begin "
            "anew without ckpt_path in another folder"
        )


def _said(value: Any) -> str:
    return "null" if value is None else str(value)


def _described(tensor: Tensor) -> str:
    mean = f", mean {tensor.double().mean():.6g}" if tensor.numel() else ""
    return f"{' × '.join(map(str, tensor.shape)) or 'none'}{mean}, {_short(tensor)}"


def _short(content: Tensor | str) -> str:
    """Eight digits that tell contents apart."""
    raw = content.encode() if isinstance(content, str) else content.contiguous().numpy().tobytes()
    return f"#{blake2b(raw, digest_size=4).hexdigest()}"
