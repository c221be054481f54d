"""Which shapes a formula can be asked about: those of which all is known that it speaks of."""

import logging
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from lssd_learn.collections.base import Collection
from lssd_learn.collections.columns import available, columns
from lssd_learn.collections.groups import read_labels
from lssd_learn.errors import InputError, some_of
from lssd_learn.exploration.blocks import block_codes
from lssd_learn.exploration.models.design import ModelDesign, design, needed

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Asked:
    """A formula and the shapes it is asked about.

    Attributes:
        shapes: (n,) positions in the collection.
        names: n of them.
        design: of these.
        blocks: (n,) which block each is of, None where nothing belongs together.
    """

    shapes: Int[np.ndarray, " n"]
    names: list[str]
    design: ModelDesign
    blocks: Int[np.ndarray, " n"] | None


def ask(collection: Collection, formula: str, blocks: str | None = None) -> Asked:
    """Read the columns of a formula; a shape of which one is unknown is left out, and told by name.

    Args:
        collection: the shapes.
        formula: see `design`.
        blocks: a grouping of shapes that belong together; one without a label stands alone.

    Raises:
        InputError: as `design` and `columns`; fewer than three shapes are left.
    """
    names = list(collection.names)
    found = columns(collection, needed(formula, available(collection)))
    unknown = np.zeros(len(names), dtype=bool)
    for values in found.values():
        unknown |= np.array([value is None or value != value for value in values])
    if unknown.any():
        log.warning(
            "%d of %d shapes are left out, of which not all of %s is known: %s",
            unknown.sum(), len(names), ", ".join(found), some_of([names[i] for i in np.flatnonzero(unknown)]),
        )  # fmt: skip
    shapes = np.flatnonzero(~unknown)
    if len(shapes) < 3:
        raise InputError(
            f"task.formula={formula}: expected three shapes or more of which all is known, got {len(shapes)}"
        )
    of = None
    if blocks is not None:
        labels = read_labels(collection, blocks, "task.blocks")
        of = block_codes([labels[i] for i in shapes], len(shapes))
    kept = [names[i] for i in shapes]
    return Asked(shapes, kept, design(formula, {name: v[shapes] for name, v in found.items()}, kept), of)
