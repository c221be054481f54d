"""Who is trained on and who is the test, and what the latent space may know of the test: `data.protocol`.

transductive   the latent space is fitted to all shapes, as in the paper
inductive      it is fitted to the training shapes alone, and the others are pushed into it
held_out_pose  inductive, and the test is one pose that training has never seen

With `data.by` shapes of one label, such as the scans of a person, stand on one side of every split.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from jaxtyping import Int

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import choose_group, read_labels
from lssd_learn.division.split import Split, split
from lssd_learn.errors import InputError, check_whole

PROTOCOLS = ("transductive", "inductive", "held_out_pose")


@dataclass(frozen=True)
class Division:
    """How a collection is divided.

    Attributes:
        split: the fractions of train, test and validation.
        protocol: one of `PROTOCOLS`.
        held_out: the pose of held_out_pose; with `by`, the label that is the test.
        by: the name of a group of the collection of which all shapes of a label stand on one side: training,
            validation or test. A shape without a label stands alone. None draws shapes by themselves.
    """

    split: Mapping[str, float] = field(default_factory=lambda: {"train": 0.75, "test": 0.15, "validation": 0.10})
    protocol: str = PROTOCOLS[0]
    held_out: str | None = None
    by: str | None = None


def divide(collection: Collection, seed: int, data: Division) -> Split:
    """The split of a collection.

    Args:
        collection: in some pose each, where one is held out: its group "pose", or its only group.
        seed: of what is drawn.
        data: how.

    Raises:
        InputError: another protocol, no such pose or group, fractions or shapes that cannot be split.
    """
    protocol, held_out = data.protocol, data.held_out
    if protocol not in PROTOCOLS:
        raise InputError(f"data.protocol={protocol}: expected one of {', '.join(PROTOCOLS)}")
    if data.by is not None:
        return _divide_by(collection, seed, data)
    if protocol != "held_out_pose":
        return split(len(collection), seed, data.split)
    name = choose_group(collection, "pose" if "pose" in collection.groups else None, "data.protocol=held_out_pose")
    labels = np.asarray(collection.groups[name]).astype(str)
    if str(held_out) not in labels:
        raise InputError(f"data.held_out={held_out}: expected one of {', '.join(dict.fromkeys(labels))}")
    return split(len(collection), seed, data.split, np.flatnonzero(labels == str(held_out)))


def _divide_by(collection: Collection, seed: int, data: Division) -> Split:
    if data.protocol == "held_out_pose":
        raise InputError(
            f"data.by={data.by}: expected data.protocol=transductive or inductive; held_out_pose has its own test, and"
            " data.by=pose data.held_out=… is the same as that"
        )
    labels = read_labels(collection, cast(str, data.by), "data.by")
    numbers = {label: i for i, label in enumerate(dict.fromkeys(label for label in labels if label is not None))}
    blocks = np.array([len(labels) + i if label is None else numbers[label] for i, label in enumerate(labels)])
    if data.held_out is None:
        return split(len(collection), seed, data.split, blocks=blocks)
    if str(data.held_out) not in numbers:
        raise InputError(f"data.held_out={data.held_out}: expected a label of {data.by}: {', '.join(numbers)}")
    out = np.flatnonzero(blocks == numbers[str(data.held_out)])
    return split(len(collection), seed, data.split, out, blocks)


def fitted(
    collection: Collection, seed: int, data: Division, number: int | None = None
) -> Int[np.ndarray, " m"] | None:
    """Positions, ascending, of the shapes the latent space is fitted to; None for all.

    Args:
        collection, seed, data: see `divide`.
        number: so many of them at most, drawn at random; the others are pushed. None takes all that the protocol
            allows. Source: "Latent shape interpolation" in the paper, 400 of 2,560.

    Raises:
        InputError: see `divide`; a number below 2 or beyond the shapes there are.
    """
    allowed = None if data.protocol == "transductive" else divide(collection, seed, data).train
    if number is None:
        return allowed
    allowed = np.arange(len(collection)) if allowed is None else allowed
    check_whole("latent.fitted", number, 2, len(allowed))
    if number == len(collection):
        return None
    return np.sort(np.random.default_rng([seed, 3]).choice(allowed, number, replace=False))
