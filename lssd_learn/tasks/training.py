"""What the tasks that train a net on the shapes of a collection have in common."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning.pytorch.utilities import rank_zero_only
from numpy.typing import ArrayLike
from torch import Tensor

from lssd_learn import nets
from lssd_learn.collections.groups import read_labels
from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.blocks import block_codes
from lssd_learn.learning import Learner, ShapeData, Split, fit, load
from lssd_learn.learning.batches import Variation
from lssd_learn.learning.checkpoint import read
from lssd_learn.learning.fit import check_trainer
from lssd_learn.learning.same import check_same
from lssd_learn.models.trained import inputs_state
from lssd_learn.nets import is_solved
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import describe
from lssd_learn.tasks.overview import write_overview
from lssd_learn.twins import check_twins, twinned
from lssd_learn.unsaid import warn_of_beyond, warn_of_blocks, warn_of_ridge, warn_of_sides

AUGMENTS = ("none", "turn", "resample", "both")
TURNING = ("turn", "both")
TARGETS = ("standardised", "raw")

# Points of the cloud that training clouds are drawn from, for one of theirs.
DENSER = 8


def plan(pieces: Pieces, epochs: int, module: type[Learner] | None = None) -> tuple[Split, int]:
    """The split and the epochs of a run, `debug` heeded. What can be wrong is found out here, before the long work.

    Args:
        module: what is to be trained; None trains no net.

    Raises:
        InputError: epochs, batch, split or debug options out of range; a net that gives something else than what is to
            be learnt; an augmentation that does not exist or does not fit net and collection.
    """
    if module is not None:
        _check_net(pieces, module)
        _check_augment(pieces)
        _blocks(pieces)
        if nets.reads(pieces.net) == "clouds":
            _check_room(pieces)
        if not nets.is_solved(pieces.net):
            check_trainer(vars(pieces.trainer))
        if pieces.ckpt_path is not None:
            check_same(pieces.ckpt_path, read(pieces.ckpt_path), _chosen(pieces))
    check_whole("task.epochs", epochs, 1)
    check_whole("data.batch", pieces.data.batch, 1)
    if (targets := pieces.data.targets) not in TARGETS:
        raise InputError(f"data.targets={targets}: expected one of {', '.join(TARGETS)}")
    parts = divide(pieces.pipeline.collection, pieces.seed, pieces.data)
    check_twins(pieces, parts)
    if pieces.debug.epochs is not None:
        check_whole("debug.epochs", pieces.debug.epochs, 1)
        epochs = min(epochs, pieces.debug.epochs)
    if pieces.debug.overfit is not None:
        check_whole("debug.overfit", pieces.debug.overfit, 1, len(parts.train))
        few = parts.train[: pieces.debug.overfit]
        parts = Split(few, few, few)
    return parts, epochs


def train(
    pieces: Pieces,
    out: Path,
    targets: ArrayLike,
    parts: Split,
    epochs: int,
    *,
    milestones: Sequence[int],
    module: type[Learner],
    references: Mapping[str, float] | None = None,
    carries: Mapping[str, Any] | None = None,
    threads: int = 1,
) -> dict[str, float]:
    """Train the net of `pieces` on the operators, or on the clouds if it reads those; leave the pictures of the run.

    Args:
        targets: (n, …) floats or (n,) integer labels.
        parts, epochs: from `plan`.
        milestones, module, references, threads: of `lssd_learn.learning.fit`.
        carries: what the checkpoint holds beside its net and inputs, see `trained.py`.

    Returns:
        The metrics of `lssd_learn.learning.fit`.
    """
    pipeline = pieces.pipeline
    clouds = pipeline.clouds(pieces.data.points) if nets.reads(pieces.net) == "clouds" else None
    seen = _seen(pieces, parts)
    if np.ndim(targets) < 3:  # parameters or classes
        _warn(pieces, targets, [name for name in ((carries or {}).get("group"), pieces.data.by) if name is not None])
    if pieces.data.twins != "none":
        twins = twinned(pieces, targets, parts)
        inputs, targets, parts = twins.operators, twins.targets, twins.split
    else:
        inputs = pipeline.operators(pieces.operators) if clouds is None else clouds
    data = ShapeData(
        inputs,
        targets,
        split=parts,
        seed=pieces.seed,
        batch=pieces.data.batch,
        standardise=pieces.data.standardise,
        variation=_variation(pieces),
        standardise_targets=pieces.data.targets == "standardised",
        blocks=_blocks(pieces),
    )
    metrics = fit(
        pieces.net,
        data,
        epochs=epochs,
        learning_rate=pieces.learning_rate,
        seed=pieces.seed,
        out=out,
        trainer_options=vars(pieces.trainer),
        ckpt_path=pieces.ckpt_path,
        milestones=milestones,
        hyperparameters=pieces.choices,
        references=references,
        carries={
            **inputs_state(pieces.net, pipeline, pieces.operators, pieces.data.points, pieces.described),
            **seen,
            **(carries or {}),
        },
        chosen=_chosen(pieces),
        module=module,
        threads=threads,
    )
    if is_solved(pieces.net):
        net = load(out / "best.ckpt", pieces.net, module).net
        outputs = (carries or {}).get("parameters") or (carries or {}).get("classes") or ()
        warn_of_ridge(net, [str(name) for name in outputs])
        if pieces.data.by is not None and pieces.data.twins == "none":
            labels = read_labels(pipeline.collection, pieces.data.by, "data.by")
            warn_of_beyond(net, data.inputs, data.split, block_codes(labels, len(labels)), pieces.data.by)
    if rank_zero_only.rank == 0:  # of the processes of a distributed run, one
        write_overview(pieces, out, clouds=clouds)
    return metrics


def _warn(pieces: Pieces, targets: ArrayLike, besides: Sequence[str]) -> None:
    """Of shapes that belong together and may be parted, and of sides."""
    collection, operators = pieces.pipeline.collection, pieces.pipeline.operators(pieces.operators)
    if pieces.data.by is None and pieces.data.protocol != "held_out_pose":
        why = "errors on shapes like those of training flatter a net"
        warn_of_blocks(collection, operators, "data.by", why, besides=besides, targets=targets)
    warn_of_sides(collection, operators, pieces.operators, besides, sides_only=True)


def _seen(pieces: Pieces, parts: Split) -> dict[str, Any]:
    """What a checkpoint says of blocks: by what, and which training and validation have seen."""
    if (by := pieces.data.by) is None:
        return {}
    labels = read_labels(pieces.pipeline.collection, by, "data.by")
    seen = {labels[i] for part in (parts.train, parts.validation) for i in part.tolist()}
    return {"by": str(by), "seen": sorted(label for label in seen if label is not None)}


def _chosen(pieces: Pieces) -> dict[str, Any]:
    """What the weights depend on, by the keys of the configuration. What the files of a folder hold is seen in the
    inputs and targets, wherever the folder lies."""
    pipeline, data = pieces.pipeline, asdict(pieces.data)
    if nets.reads(pieces.net) != "clouds":
        data = {name: value for name, value in data.items() if name not in ("points", "augment")}
    nodes = {
        "collection": {name: value for name, value in pieces.described.items() if name not in ("path", "up")},
        "data": data,
        "net": {"learning_rate": pieces.learning_rate, **describe(pieces.net)[-1]},
    }
    return {
        "seed": pieces.seed,
        "collection": pieces.choices["collection"],
        "net": pieces.choices["net"],
        "network": pieces.choices["network"],
        **{f"{group}.{name}": value for group, node in nodes.items() for name, value in node.items()},
        "basis.k": pipeline.k,
        "latent.size": pipeline.size,
        "latent.keep": pipeline.keep,
        "latent.operators": list(pieces.operators),
        "latent.fitted": None if pipeline.fitted is None else len(pipeline.fitted),
        "debug.overfit": pieces.debug.overfit,
    }


def tested_inputs(pieces: Pieces, parts: Split) -> Tensor:
    """What the net of a run reads of the test shapes: operators (t, channels, m, m) or clouds (t, points, 3)."""
    if nets.reads(pieces.net) == "clouds":
        return torch.tensor(pieces.pipeline.clouds(pieces.data.points)[parts.test])
    return pieces.pipeline.operators(pieces.operators)[parts.test]


def _check_net(pieces: Pieces, module: type[Learner]) -> None:
    if (given := nets.writes(pieces.net)) != module.predicts:
        name = pieces.choices["net"]
        raise InputError(f"net={name}: expected a net that gives {module.predicts}, this one gives {given}")


def _blocks(pieces: Pieces) -> np.ndarray | None:
    """(n,) what `data.rehearse` leaves out together."""
    if (name := pieces.data.rehearse) is None:
        return None
    key = f"data.rehearse={name}"
    if not nets.rehearses(pieces.net) or pieces.data.twins != "none":
        raise InputError(f"{key}: expected net=kernel and data.twins=none")
    labels = read_labels(pieces.pipeline.collection, name, "data.rehearse")
    return block_codes(labels, len(labels))


def _check_augment(pieces: Pieces) -> None:
    augment = pieces.data.augment
    if augment not in AUGMENTS:
        raise InputError(f"data.augment={augment}: expected one of {', '.join(AUGMENTS)}")
    if augment != "none" and nets.reads(pieces.net) != "clouds":
        raise InputError(
            f"data.augment={augment}: expected a net on clouds; net={pieces.choices['net']} reads operators"
        )
    if augment in TURNING and pieces.pipeline.collection.up is None:
        raise InputError(f"data.augment={augment}: expected to know which axis is up; collection.up=y or z says it")


def _check_room(pieces: Pieces) -> None:
    """Refuse clouds that this machine could not hold: as float32, and once more in the making."""
    n, points = len(pieces.pipeline.collection), pieces.data.points
    check_whole("data.points", points, 1)
    copies = 2 + (DENSER if pieces.data.augment in ("resample", "both") else 0)
    wanted, there = copies * n * points * 3 * 4, memory()
    if there is not None and wanted > there:
        most = there // (copies * n * 3 * 4)
        raise InputError(
            f"data.points={points}: {n:,} clouds of so many points take {wanted / 2**30:,.0f} GiB, and this machine "
            f"has {there / 2**30:,.0f}; expected {most:,} or fewer"
        )


def memory() -> int | None:
    """Bytes of memory of this machine; None where it does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # Windows
        return None


def _variation(pieces: Pieces) -> Variation | None:
    """What `data.augment` asks for; None for nothing."""
    augment, pipeline = pieces.data.augment, pieces.pipeline
    if augment == "none":
        return None
    denser = None if augment == "turn" else pipeline.clouds(DENSER * pieces.data.points)
    return Variation(pieces.seed, pipeline.collection.up if augment in TURNING else None, denser)
