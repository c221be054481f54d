"""The groups of a collection, as tasks choose one and count its labels."""

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError


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


def encode(labels: ArrayLike) -> tuple[list[str] | list[int], np.ndarray]:
    """Classes in ascending order, and for each of the n labels, numbers or texts, its place among them (int64)."""
    labels = np.asarray(labels)
    classes, places = np.unique(labels if labels.dtype.kind in "iu" else labels.astype(str), return_inverse=True)
    return classes.tolist(), places.astype(np.int64)
