"""The groups of a collection, as a person chooses them, and their labels counted."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError

UNKNOWN = ("", "None", "nan")  # labels that say nothing


@dataclass(frozen=True)
class ChosenGroups:
    """Some groups of shapes.

    Attributes:
        name: what the shapes are grouped by.
        labels: of the groups that are compared, as texts, in ascending order or as they were asked for.
        shapes: (n,) positions in the collection of the shapes that are looked at.
        of: n labels; None is a shape whose group is not known, which is looked at and otherwise plays no part.
        blocks: n labels of what belongs together, None a shape that stands alone; None where nothing does.
    """

    name: str
    labels: list[str]
    shapes: np.ndarray
    of: list[str | None]
    blocks: list[str | None] | None = None

    def members(self, label: str) -> np.ndarray:
        """The positions in the collection of the shapes of one group."""
        return self.shapes[[other == label for other in self.of]]


def choose_group(collection: Collection, name: str | None, asked: str) -> str:
    """The name of a group.

    Args:
        collection: whose groups.
        name: of one of them; None is the only one there is.
        asked: what the name was given as, for messages.

    Raises:
        InputError: no such group, none at all, or several and no name.
    """
    known = list(collection.groups)
    if not known:
        raise InputError(f"{asked}: expected shapes with groups; {collection.lacks('groups')}")
    if name is None and len(known) > 1:
        raise InputError(f"{asked}: expected one of {', '.join(known)}")
    name = known[0] if name is None else str(name)  # 2024 is a name too
    if name not in known:
        why = f"; {collection.lacks('groups', name)}" if name in collection.parameter_names else ""
        raise InputError(f"{asked}={name}: expected one of {', '.join(known)}{why}")
    return name


def choose_groups(
    collection: Collection,
    group: str | None = None,
    labels: Sequence = (),
    unlabelled: str | None = None,
    blocks: str | None = None,
) -> ChosenGroups:
    """The groups to compare.

    Args:
        collection: whose groups.
        group: the name of one of its groupings; None is the only one there is.
        labels: two or more of its labels, and then shapes of others are left out; empty is all.
        unlabelled: the label of shapes whose group is not known. (A label that is empty says so too.)
        blocks: the name of another grouping, of shapes that belong together; None is none.

    Raises:
        InputError: no such grouping or label, fewer than two groups, a group of one shape or of one block.
    """
    name = choose_group(collection, group, "task.group")
    unknown = UNKNOWN if unlabelled is None else (*UNKNOWN, str(unlabelled))
    found = [None if str(label) in unknown else str(label) for label in collection.groups[name]]
    counts = Counter(label for label in found if label is not None)
    known = sorted(counts)
    chosen = list(dict.fromkeys(map(str, labels))) or known
    asked = f"task.group={name}" if not len(labels) else f"task.labels=[{','.join(map(str, labels))}]"
    if missing := [label for label in chosen if label not in counts]:
        raise InputError(f"{asked}: {name} has no label {missing[0]!r}; it has {', '.join(known)}")
    if len(chosen) < 2:
        raise InputError(f"{asked}: expected two labels or more to compare, got {', '.join(chosen) or 'none'}")
    if alone := [label for label in chosen if counts[label] < 2]:
        raise InputError(f"{asked}: expected two shapes or more of each label, got one of {alone[0]!r}")
    compared = {None, *chosen}
    shapes = np.array([i for i, label in enumerate(found) if label in compared])
    of = [found[i] for i in shapes]
    return ChosenGroups(name, chosen, shapes, of, None if blocks is None else _blocks(collection, blocks, shapes, of))


def read_labels(collection: Collection, name: str, asked: str) -> list[str | None]:
    """The labels of a grouping as texts, None where a shape has none.

    Raises:
        InputError: as `choose_group`.
    """
    labels = collection.groups[choose_group(collection, name, asked)]
    return [None if str(label) in UNKNOWN else str(label) for label in labels]


def _blocks(collection: Collection, name: str, shapes: np.ndarray, of: Sequence[str | None]) -> list[str | None]:
    asked = f"task.blocks={name}"
    labels = read_labels(collection, name, "task.blocks")
    found = [labels[i] for i in shapes]
    own: dict[str, set[str | int]] = {}
    for i, (block, label) in enumerate(zip(found, of, strict=True)):
        if label is not None:
            own.setdefault(label, set()).add(i if block is None else block)
    if alone := [label for label, blocks in own.items() if len(blocks) < 2]:
        raise InputError(f"{asked}: expected two blocks or more with shapes of each label, got one of {alone[0]!r}")
    return found


def encode(labels: ArrayLike) -> tuple[list[str] | list[int], np.ndarray]:
    """Classes in ascending order, and for each of the n labels, numbers or texts, its place among them (int64)."""
    labels = np.asarray(labels)
    classes, places = np.unique(labels if labels.dtype.kind in "iu" else labels.astype(str), return_inverse=True)
    return classes.tolist(), places.astype(np.int64)
