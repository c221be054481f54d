"""What a design compares: all shapes with one another or, with blocks, shapes within blocks and blocks with each other.

A term that varies within blocks, as the state of a person who was scanned twice, is asked about there, with what blocks
differ by taken out, and residuals are permuted within blocks: of pairs, the signs of their differences flip. What is
constant in blocks is asked about between them, and whole blocks of equal size are exchanged. A number that does both
has a part in each, as in R's aov with an Error term.

Source: Winkler, Webster, Vidaurre, Nichols & Smith, "Multi-level block permutation", NeuroImage 123 (2015).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import InputError
from lssd_learn.exploration.blocks import Design
from lssd_learn.exploration.models.design import ASKED, ModelDesign

# Columns of a design that are less than this part of their length are nothing but rounding.
NOTHING = 1e-8
KINDS = ("I", "II", "III")  # of sums of squares


@dataclass(frozen=True, eq=False)
class Stratum:
    """The u units of one kind of comparison, shapes or blocks, and how their residuals may be permuted.

    Attributes:
        name: "" within blocks or without, else "between person".
        carry: (u, n) takes values of shapes to units; what is no part of the comparison, as the mean, is taken out.
        X: (u, p) the design so carried, columns divided by their scale.
        scale: (p,) the length of columns about their mean; infinite of the intercept.
        free: how many degrees of freedom the units have.
        rows: (N, u) in permutation b the residual of unit i meets the design of unit rows[b, i]; first all as they are.
            One alone where nothing can be exchanged.
        exact: whether the permutations are all there are, each once.
    """

    name: str
    carry: Float[np.ndarray, "u n"]
    X: Float[np.ndarray, "u p"]
    scale: Float[np.ndarray, " p"]
    free: int
    rows: Int[np.ndarray, "N u"]
    exact: bool

    @property
    def rest(self) -> int:
        """Degrees of freedom of the residuals."""
        return self.free - orthonormal(self.X).shape[1]


def strata(
    design: ModelDesign, blocks: Int[np.ndarray, " n"] | None, name: str = "", permutations: int = 999, seed: int = 0
) -> list[Stratum]:
    """The comparisons of a design, blocks first.

    Args:
        design: of n shapes.
        blocks: (n,) which block each shape is of; None without.
        name: what the blocks are.
        permutations: at random beside the first; where there are no more, all.
        seed: of these.

    Raises:
        InputError: nothing to permute.
    """
    X, n = design.X, len(design.X)
    scale = np.linalg.norm(X - X.mean(0), axis=0)
    scale = np.where(scale > NOTHING * np.linalg.norm(X, axis=0), scale, np.inf)
    X = X / scale  # the intercept and its like are 0
    how = scale, permutations, seed
    if blocks is None:
        return [_stratum("", np.eye(n) - 1 / n, X, X, np.zeros(n, dtype=int), n - 1, *how)]
    blocks = np.unique(blocks, return_inverse=True)[1]
    sizes = np.bincount(blocks)
    member = (blocks == np.arange(len(sizes))[:, None]) / np.sqrt(sizes)[:, None]  # (B, n), orthonormal rows
    root = np.sqrt(sizes)[:, None] / np.sqrt(n)
    between = member - root @ (root.T @ member)
    means = member @ X / np.sqrt(sizes)[:, None]
    within = np.eye(n) - member.T @ member
    found = [
        _stratum(f"between {name}", between, X, means, sizes, len(sizes) - 1, *how),
        _stratum("", within, X, X, blocks, n - len(sizes), *how),
    ]
    found = [part for part in found if (np.linalg.norm(part.X, axis=0) > NOTHING).any()]
    if all(len(part.rows) == 1 for part in found):
        raise InputError(
            f"task.blocks={name}: expected blocks within which the shapes differ, or several of equal size that can be"
            " exchanged; there is nothing to permute"
        )
    return found


def _stratum(
    name: str,
    carry: np.ndarray,
    X: np.ndarray,
    own: np.ndarray,
    exchanged: np.ndarray,
    free: int,
    scale: np.ndarray,
    many: int,
    seed: int,
) -> Stratum:
    """Of u units with rows (u, p) of their own of the design, whose residuals are exchanged where `exchanged` is the
    same: units alike in the design and there need no exchange."""
    keys = np.column_stack([exchanged, own.round(10)])
    _, first, codes = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    codes = codes.ravel()
    members = [np.flatnonzero(exchanged == value) for value in np.unique(exchanged)]
    units = [some[:, None] for some in members if len(set(codes[some])) > 1]
    groupings, exact = Design(codes, exchanged, units, np.ones(len(own), dtype=bool), 0).groupings(many, seed)
    return Stratum(name, carry, carry @ X, scale, free, first[groupings], exact)


def ensure_testable(design: ModelDesign, parts: Sequence[Stratum], kind: str) -> None:
    """Refuse a formula of which a term cannot be tested.

    Args:
        design, parts, kind: as for `model_table`.

    Raises:
        InputError: an unknown kind of sums of squares; no residuals, a term that says nothing that others do not.
    """
    if kind not in KINDS:
        raise InputError(f"task.sums={kind}: expected I, II or III")
    for part in parts:
        columns = orthonormal(part.X).shape[1]
        if part.free <= columns and not part.name:
            raise InputError(
                f"{ASKED}={design.formula}: expected fewer terms, {part.free} differences of shapes leave no residuals"
                f" beside {columns} columns"
            )
    tested = {name for part in parts if part.rest > 0 for name, _, _ in bases(part, design, kind)}
    if lost := [term.name for term in design.terms if term.name not in tested]:
        raise InputError(
            f"{ASKED}={design.formula}: expected terms that say something of their own, and shapes or blocks enough for"
            f" residuals; {lost[0]} does not"
        )


def orthonormal(X: Float[np.ndarray, "u p"]) -> Float[np.ndarray, "u q"]:
    """A basis of the span of columns of length about one: what is left of one less than `NOTHING` is no column."""
    if not X.shape[1]:
        return X
    U, sizes, _ = np.linalg.svd(X, full_matrices=False)
    return U[:, sizes > NOTHING]


def bases(
    stratum: Stratum, design: ModelDesign, kind: str
) -> list[tuple[str, Float[np.ndarray, "u q"], Float[np.ndarray, "u k"]]]:
    """Of each term (name, what it adds to the others, the others), orthonormal; terms that add nothing are left out.

    Args:
        stratum: of the design.
        design: its terms.
        kind: of sums of squares: "I", others are the terms before it; "II", all but those that contain it; "III", all.

    """
    found = []
    for place, term in enumerate(design.terms):
        above = design.containing(term)
        others = {
            "I": design.terms[:place],
            "II": [other for other in design.terms if other is not term and other not in above],
            "III": [other for other in design.terms if other is not term],
        }[kind]
        R = orthonormal(_columns(stratum, [other.columns for other in others]))
        X = stratum.X[:, term.columns]
        U = orthonormal(X - R @ (R.T @ X))
        if U.shape[1]:
            found.append((term.name, U, R))
    return found


def _columns(stratum: Stratum, slices: Sequence[slice]) -> np.ndarray:
    return np.concatenate([stratum.X[:, some] for some in slices] or [stratum.X[:, :0]], axis=1)
