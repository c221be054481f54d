"""How the shapes of a collection are to be laid: pairs on each other, then all of them in one frame.

Pairs are laid over a sparse network (`shapes/rigid.py`), and the turns of the network averaged (`turns.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lssd_learn.collections.alignment.turns import (
    angles_between,
    medians,
    reached,
    shifts,
    sides,
    sparse_pairs,
    turns,
)
from lssd_learn.collections.base import Collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.errors import InputError
from lssd_learn.shapes.closest_points import Sampled, sampled
from lssd_learn.shapes.rigid import FLOOR, TIE, Rigid, both_sides, is_better

VERSION = 1  # goes up whenever the same shapes and arguments come to lie otherwise
ALIGN = ("none", "rigid", "auto")

UNLIKE = 0.06  # residual, in parts of the size, from which two shapes are not of one kind and pose
STRANGE = 2.5  # times the collection's own residual: a shape that fits no other better is of another kind
LEAST = 0.025  # residual below which no shape is strange, however alike the others are
LACKING = 0.05  # share of the others' surface, beyond what the collection's shapes lack anyway, that a part lacks
ALIKE = 15.0  # degrees within which shapes lie alike as they are
LOOKED_AT = 8  # pairs that tell so
TINY = 1e-3  # of what counts for next to nothing


@dataclass(frozen=True, eq=False)
class Lie:
    """How n shapes were laid, and how well; arrays as the cache keeps them.

    Attributes:
        rotation, shift: (n, 3, 3) and (n, 3), shape i lies as `vertices @ rotation + shift`; mirrored where the
            determinant is −1.
        residual, other, rival: (n,) medians over the pairs of a shape, of the side it was given, the other side, and
            the best other turn; in parts of its size, see `Rigid`. NaN where shapes were left as they lie.
        missing, extra: (n,) the share of the others' surface that the shape lacks, and of its own that they lack.
        fits: (n,) bool, whether the shape is of the kind that most are.
        off: (n,) degrees, the median by which its pairs disagree with the turn it was given.
        left: why shapes were left as they lie; "" where they were laid.
    """

    rotation: np.ndarray
    shift: np.ndarray
    residual: np.ndarray
    other: np.ndarray
    rival: np.ndarray
    missing: np.ndarray
    extra: np.ndarray
    fits: np.ndarray
    off: np.ndarray
    left: np.ndarray

    @property
    def mirrored(self) -> np.ndarray:
        return np.linalg.det(self.rotation) < 0

    @property
    def partial(self) -> np.ndarray:
        """(n,) bool: of one kind with the others, but a part of it is not there."""
        lacking = self.missing - np.median(self.missing)
        return self.fits & (lacking > LACKING) & (self.missing > self.extra + LACKING / 2)


def find(collection: Collection, align: str = "rigid", mirror: str = "auto", workers: int | None = None) -> Lie:
    """How the shapes of a collection are to be laid; see `Aligned`."""
    n = len(collection)
    if align == "none" or n < 2:
        return _as_they_lie(n, "")
    read = list(in_parallel(_sample, range(n), "sampling", workers, collection))
    known = {connectivity for _, connectivity in read}
    if align == "auto" and len(known) == 1 and known != {None}:
        return _as_they_lie(n, "they are in vertex correspondence")
    samples = _Samples([sample for sample, _ in read])
    pairs = sparse_pairs(n)
    if align == "auto":
        some = pairs[np.linspace(0, len(pairs) - 1, min(LOOKED_AT, len(pairs))).astype(int)]
        looks = [_pair(p, samples, some, mirror) for p in range(len(some))]
        if all(look[0].angle < ALIKE and not _is_mirrored(look, mirror) for look in looks):
            return _as_they_lie(n, "they lie alike already")
    found = list(in_parallel(_pair, range(len(pairs)), "alignment", workers, samples, pairs, mirror))
    lie = _put_together(n, pairs, found, mirror)
    if align == "auto" and np.median(lie.residual) > UNLIKE:
        left = _as_they_lie(n, "no turn lays them on each other")
        return Lie(**{**vars(lie), "rotation": left.rotation, "shift": left.shift, "left": left.left})
    return lie


def _is_mirrored(look: tuple[Rigid, Rigid | None], mirror: str) -> bool:
    own, other = look
    return other is not None and is_better(other, own, mirror)


class _Samples(Sequence[Sampled]):
    """Samples of many shapes in a few arrays, which worker processes share."""

    def __init__(self, samples: Sequence[Sampled]):
        self._ends = np.cumsum([0, *(len(sample.points) for sample in samples)])
        self._points, self._normals = (np.concatenate([getattr(s, a) for s in samples]) for a in ("points", "normals"))
        self._rest = [(s.oriented, s.centre, s.size) for s in samples]

    def __len__(self) -> int:
        return len(self._rest)

    def __getitem__(self, i: int) -> Sampled:
        own = slice(self._ends[i], self._ends[i + 1])
        return Sampled(self._points[own], self._normals[own], *self._rest[i])


def _sample(i: int, collection: Collection) -> tuple[Sampled, str | None]:
    shape = collection[i]
    try:
        return sampled(shape), shape.connectivity
    except InputError as error:
        raise InputError(f"{collection.names[i]}: {error}") from error


def _pair(p: int, samples: _Samples, pairs: np.ndarray, mirror: str) -> tuple[Rigid, Rigid | None]:
    """The first shape of a pair on the second, on its own side and on the other."""
    i, j = pairs[p]
    return both_sides(samples[i], samples[j], mirror != "forbid")


def _put_together(n: int, pairs: np.ndarray, found: Sequence[tuple[Rigid, Rigid | None]], mirror: str) -> Lie:
    residuals = np.array([[np.inf if rigid is None else rigid.residual for rigid in pair] for pair in found])
    if mirror == "forbid":
        side = np.ones(n, dtype=int)
    else:
        evidence = np.log(np.maximum(residuals[:, 1], FLOOR) / np.maximum(residuals[:, 0], FLOOR))
        told = np.abs(evidence) > (np.log(TIE) if mirror == "auto" else 0.0)
        side = sides(n, pairs, np.where(told, evidence, TINY))
    on = (side[pairs[:, 0]] * side[pairs[:, 1]] < 0).astype(int)
    chosen = [pair[k] for pair, k in zip(found, on, strict=True)]
    residual, other = (residuals[np.arange(len(pairs)), k] for k in (on, 1 - on))
    Q, t = (np.stack([getattr(rigid, name) for rigid in chosen]) for name in ("rotation", "shift"))
    rival, missing, extra = (np.array([getattr(rigid, name) for rigid in chosen])
                             for name in ("rival", "missing", "extra"))  # fmt: skip

    P = turns(n, pairs, Q, residual)
    best = np.array([residual[(pairs == i).any(axis=1)].min() for i in range(n)])
    good = residual <= max(LEAST, STRANGE * np.median(best))
    fits = reached(n, pairs, good)
    off = angles_between(P[pairs[:, 0]], Q @ P[pairs[:, 1]])
    u = shifts(n, pairs, P, t, np.where(good & (off < ALIKE), 1.0, TINY))
    r = _frame(P, fits)
    rotation, shift = P @ P[r].T, (u - u[r]) @ P[r].T
    rotation[r], shift[r] = np.eye(3), 0.0

    among = good | ~fits[pairs].all(axis=1)  # of those that fit, the pairs that do; of the others all

    def over(values: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
        """Medians over the pairs of each shape, of what the first and the second of a pair see."""
        return medians(n, pairs[among], values[among], (values if seen is None else seen)[among])

    return Lie(
        rotation, shift, over(residual), over(other), over(rival), over(missing, extra), over(extra, missing),
        fits, over(off), np.array(""),
    )  # fmt: skip


def _frame(P: np.ndarray, fits: np.ndarray) -> int:
    """The shape that the others of its side need to be turned least for, of the side that most are of."""
    mirrored = np.linalg.det(P) < 0
    mirrored = mirrored != mirrored[np.flatnonzero(fits)[0]]
    side = np.flatnonzero(fits & (mirrored == (mirrored[fits].sum() > fits.sum() / 2)))
    return int(side[np.argmin([np.sum(angles_between(P[side], P[r])) for r in side])])


def _as_they_lie(n: int, why: str) -> Lie:
    nothing = np.full(n, np.nan)
    return Lie(np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), nothing, nothing, nothing, nothing, nothing,
               np.ones(n, dtype=bool), nothing, np.array(why))  # fmt: skip
