"""The groups of a collection, as a person chooses them, and their labels counted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError


@dataclass(frozen=True)
class ChosenGroups:
    """Some groups of shapes.

    Attributes:
        name: what the shapes are grouped by.
        labels: of the groups that are compared, as texts, in ascending order or as they were asked for.
        shapes: (n,) positions in the collection of the shapes that are looked at.
        of: n labels; None is a shape whose group is not known, which is looked at and otherwise plays no part.
    """

    name: str
    labels: list[str]
    shapes: np.ndarray
    of: list[str | None]

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
    collection: Collection, group: str | None = None, labels: Sequence = (), unlabelled: str | None = None
) -> ChosenGroups:
    """The groups to compare.

    Args:
        collection: whose groups.
        group: the name of one of its groupings; None is the only one there is.
        labels: two or more of its labels, and then shapes of others are left out; empty is all.
        unlabelled: the label of shapes whose group is not known. (A label that is empty says so too.)

    Raises:
        InputError: no such grouping or label, fewer than two groups, a group of one shape.
    """
    name = choose_group(collection, group, "task.group")
    unknown = ("", "None", "nan") if unlabelled is None else ("", "None", "nan", str(unlabelled))
    found = [None if str(label) in unknown else str(label) for label in collection.groups[name]]
    known = sorted({label for label in found if label is not None})
    chosen = list(dict.fromkeys(map(str, labels))) or known
    asked = f"task.group={name}" if not len(labels) else f"task.labels=[{','.join(map(str, labels))}]"
    if missing := [label for label in chosen if label not in known]:
        raise InputError(f"{asked}: {name} has no label {missing[0]!r}; it has {', '.join(known)}")
    if len(chosen) < 2:
        raise InputError(f"{asked}: expected two labels or more to compare, got {', '.join(chosen) or 'none'}")
    if alone := [label for label in chosen if found.count(label) < 2]:
        raise InputError(f"{asked}: expected two shapes or more of each label, got one of {alone[0]!r}")
    shapes = np.array([i for i, label in enumerate(found) if label is None or label in chosen])
    return ChosenGroups(name, chosen, shapes, [found[i] for i in shapes])


def encode(labels: ArrayLike) -> tuple[list[str] | list[int], np.ndarray]:
    """Classes in ascending order, and for each of the n labels, numbers or texts, its place among them (int64)."""
    labels = np.asarray(labels)
    classes, places = np.unique(labels if labels.dtype.kind in "iu" else labels.astype(str), return_inverse=True)
    return classes.tolist(), places.astype(np.int64)
