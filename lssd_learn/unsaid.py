"""Warnings of what nobody asked about: columns of blocks or sides, operators of another kind that answer otherwise."""

import logging
from collections.abc import Collection as Some
from collections.abc import Mapping
from typing import cast

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor, nn

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import ChosenGroups
from lssd_learn.division.split import Split
from lssd_learn.exploration.belonging import alike_within, belonging, ruling, whole_numbers
from lssd_learn.exploration.separation import permutation_test
from lssd_learn.pieces import Pieces

log = logging.getLogger(__name__)

BOTH = ("area", "conformal")  # a test by each of these, whatever is looked at
LEVEL = 0.05  # of p, on two sides of which two tests answer otherwise
# The part of the test shapes that may be unlike those of training; how near the range's end, in parts of it, is cut.
MANY, SLACK = 0.2, 1e-5
SIDES = ({"left", "right"}, {"l", "r"})


def warn_of_blocks(
    collection: Collection,
    operators: Tensor,
    key: str,
    why: str,
    shapes: ArrayLike | None = None,
    besides: Some[str] = (),
    targets: ArrayLike | None = None,
) -> None:
    """Name a column whose shapes look as if they belonged together.

    Args:
        collection: whose columns: groups, and parameters that are whole numbers.
        operators: (n, channels, m, m) of the collection.
        key: what would say so, as "task.blocks".
        why: what goes wrong without.
        shapes: positions of those that are looked at; None is all.
        besides: columns that are not meant.
        targets: (n, …) what is learnt: only columns within which it hardly varies are told. None tells all.
    """
    shapes = np.arange(len(collection)) if shapes is None else np.asarray(shapes)
    numbers = whole_numbers(collection.parameters, collection.parameter_names)
    columns = {name: np.asarray(labels) for name, labels in (numbers | dict(collection.groups)).items()}
    columns = {name: labels[shapes] for name, labels in columns.items() if name not in besides}
    for found in belonging(operators[shapes], columns):
        if targets is not None and not alike_within(np.asarray(targets)[shapes], columns[found.name]):
            continue
        given = "" if found.name in collection.groups else f"collection.groups=[{found.name}] "
        log.warning(
            "%s looks like a block of shapes that belong together: %.0f %% of the shapes have their nearest in the same"
            " one (%.0f %% by chance), and %s; %s%s=%s",
            found.name, 100 * found.shared, 100 * found.chance, why, given, key, found.name,
        )  # fmt: skip
        return


def warn_of_sides(
    collection: Collection, operators: Tensor, kinds: Some[str], besides: Some[str] = (), sides_only: bool = False
) -> None:
    """Say which column that was not asked for the first two principal components of the operators follow.

    Args:
        collection: whose groups.
        operators: (n, channels, m, m) of the collection.
        kinds: names of the channels.
        besides: groups that were asked for.
        sides_only: of columns of sides alone, left and right.
    """
    columns = {name: labels for name, labels in collection.groups.items() if name not in besides}
    if sides_only:
        columns = {name: labels for name, labels in columns.items() if _is_side(labels)}
    told = set()
    for c, kind in enumerate(kinds):
        for name, axis, value in ruling(operators[:, c], columns):
            if name in told:
                continue
            told.add(name)
            hint = (
                "; collection.align=rigid collection.mirror=allow lays all shapes on one side"
                if _is_side(columns[name])
                else ""
            )
            log.warning(
                "principal component %d of the %s operators is %s (correlation %.2f), which nothing here asks for%s",
                axis, kind, name, value, hint,
            )  # fmt: skip


def warn_of_beyond(net: nn.Module, inputs: Tensor, split: Split, blocks: ArrayLike, by: str) -> None:
    """Say where a kernel machine is asked about shapes beyond those it knows, which it cannot answer.

    Far from all training shapes its answer is their mean, and with bounds it stays within their range.

    Args:
        net: trained on operators.
        inputs: (n, channels, m, m) these, and those of the other shapes.
        split: who is who.
        blocks: (n,) numbers of what belongs together.
        by: what the blocks are.
    """
    parts = {name: torch.from_numpy(positions) for name, positions in split.items()}
    x, of = inputs.flatten(1), torch.as_tensor(blocks)
    train, test = parts["train"], parts["test"]
    own = torch.cdist(x[train], x[train]).masked_fill_(of[train][:, None] == of[train], torch.inf).amin(1)
    limit = own[own.isfinite()].quantile(0.95) if own.isfinite().any() else torch.inf
    far = int((torch.cdist(x[test], x[train]).amin(1) > limit).sum())
    with torch.no_grad():
        found = net(inputs[test]).double()
    low, high = cast(torch.Tensor, net.bounds)
    cut = int(((found < low + SLACK * (high - low)) | (found > high - SLACK * (high - low))).any(1).sum())
    if far > MANY * len(test) or cut:
        log.warning(
            "%d of %d test shapes are less like the training shapes than these are like each other across %s, and"
            " predictions of %d are cut at the range of training (not by net.bounded=false): a kernel machine does not"
            " extrapolate; trust reference/ridge where it does better",
            far, len(test), by, cut,
        )  # fmt: skip


def warn_of_ridge(net: nn.Module, names: Some[str]) -> None:
    """Say which outputs of a kernel machine are a ridge's, which predicts them better on validation.

    Args:
        net: trained.
        names: of its outputs; none numbers them.
    """
    linear = cast(Tensor, net.linear).tolist()
    names = names or [f"output {i}" for i in range(len(linear))]
    if chosen := [name for name, straight in zip(names, linear, strict=True) if straight]:
        log.warning(
            "%s: predicted by a ridge, without bounds, which does better on the validation shapes than the kernel"
            " machine: it does not extrapolate",
            ", ".join(chosen),
        )


def warn_of_seen(collection: Collection, by: str, seen: Some[str]) -> None:
    """Say which blocks of a collection a net has been trained on.

    Args:
        collection: new shapes.
        by: the group the training split was made by.
        seen: its labels in training and validation.
    """
    if by not in collection.groups:
        return
    labels = [str(label) for label in collection.groups[by]]
    if again := [label for label in dict.fromkeys(labels) if label in set(seen)]:
        told = ", ".join(again[:3]) + (", …" if len(again) > 3 else "")
        log.warning(
            "%d of %d shapes are of a %s that the net was trained on (%s): errors on these flatter it",
            sum(label in again for label in labels), len(labels), by, told,
        )  # fmt: skip


def warn_of_disagreement(
    pieces: Pieces,
    groups: ChosenGroups,
    p_values: Mapping[str, float],
    permutations: int,
    method: str,
    epsilon: float,
) -> None:
    """Say where area and conformal operators, those too that the run does not look at, disagree about chance.

    Args:
        pieces: of the run.
        groups: that are compared.
        p_values: kind of operator → p, those known already.
        permutations, method, epsilon: of `permutation_test`.
    """
    found, others = dict(p_values), [kind for kind in BOTH if kind not in p_values]
    if others:
        D = pieces.pipeline.operators(others)[groups.shapes]
        for c, kind in enumerate(others):
            test = permutation_test(D[:, c], groups.of, permutations, pieces.seed, method, epsilon, groups.blocks)
            found[kind] = test.p_value
    if len({p < LEVEL for p in found.values()}) > 1:
        told = ", ".join(f"{kind} p = {p:.3g}" for kind, p in found.items())
        more = f"; latent.operators=[{','.join(found)}] shows what they tell" if others else ""
        log.warning("the operators do not answer alike: %s%s", told, more)


def _is_side(labels: ArrayLike) -> bool:
    return {str(label).strip().casefold() for label in np.asarray(labels)} in SIDES
