"""Where on the shape: the same linear model at every point, and how large a difference is anywhere by chance.

What stands for the size of shape i at a vertex with the function φ of unit length that is most concentrated there is
s_i = log φᵀD_iφ, of area operators the logarithm of the local area ratio, as smooth as m functions are.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike
from scipy.stats import t as student
from torch import Tensor

from lssd_learn.exploration.evidence import concentrated
from lssd_learn.exploration.models.clusters import Cells, enhanced
from lssd_learn.exploration.models.contrasts import contrasts, weights
from lssd_learn.exploration.models.design import ModelDesign, ModelTerm
from lssd_learn.exploration.models.effects import SAME, Chance, reached
from lssd_learn.exploration.models.residuals import permuted_products
from lssd_learn.exploration.models.strata import Stratum, bases, orthonormal
from lssd_learn.latent import LatentSpace

LEVEL = 0.05  # of the family-wise p below which a point counts, and of intervals
PAIRS = 6  # of groups of a term; where there are more, its fields are of its F alone
DRAWN = 200  # permutations that the share of false points is estimated from


@dataclass(frozen=True, eq=False)
class PointField:
    """What a term does at V points.

    Attributes:
        term: its name.
        title: the contrast; "" where there is an F alone.
        effect: (V,) of the logarithm, 1 sd of a number or between two groups; of an F alone, the standard deviation
            that the term explains.
        low, high: (V,) interval of 95 % of each point by itself; nan of an F alone.
        statistic: (V,) t, or of an F alone its root.
        p: (V,) the chance of a statistic as large anywhere, over all points, kinds and contrasts of the term.
        p_enhanced: (V,) the same of `enhanced` statistics: what is wide counts more, what is narrow less.
        false: (V,) of the points with a statistic as large or larger, the share (by area) expected without an effect.
        least: (V,) how large it is at least, at all points at once with 95 % confidence; 0 where it may be nothing.
        shrunk: (V,) effect (1 − (m / statistic)²), 0 where the statistic is below m, the median of the largest anywhere
            by chance: as good as the effect where it is sure, and nothing where there is nothing (non-negative garrote:
            Breiman, Technometrics 37, 1995).
    """

    term: str
    title: str
    effect: Float[np.ndarray, " V"]
    low: Float[np.ndarray, " V"]
    high: Float[np.ndarray, " V"]
    statistic: Float[np.ndarray, " V"]
    p: Float[np.ndarray, " V"]
    p_enhanced: Float[np.ndarray, " V"]
    false: Float[np.ndarray, " V"]
    least: Float[np.ndarray, " V"]
    shrunk: Float[np.ndarray, " V"]

    @property
    def significant(self) -> Bool[np.ndarray, " V"]:
        """(V,) where p is below 5 %."""
        return self.p <= LEVEL

    @property
    def core(self) -> Bool[np.ndarray, " V"]:
        """(V,) where it is significant, and more than half as large as where it is largest.

        What is significant goes further than what changed, the more so the surer it is: a field is as smooth as its
        functions are.
        """
        return self.significant & (np.abs(self.effect) > np.abs(self.effect).max() / 2)


def local_sizes(
    latent: LatentSpace, operators: Float[Tensor, "n m m"], i: int, live: Bool[Tensor, " m"] | None = None
) -> Float[np.ndarray, "n V"]:
    """s (n, V): log φᵀD_jφ of n shapes at the vertices of shape i.

    Args:
        latent: with its eigenbases.
        operators: (n, m, m) positive definite on the live functions.
        i: the shape whose vertices are asked about.
        live: (m,) bool, the functions that are not null; None is all.
    """
    functions = concentrated(latent, i, live).cpu()
    D = operators if live is None else operators[:, live][:, :, live]
    return torch.stack([((functions @ one) * functions).sum(1).log() for one in D.cpu()]).numpy()


def anywhere(
    sizes: Mapping[str, Float[np.ndarray, "n c"]], design: ModelDesign, term: ModelTerm, part: Stratum, cells: Cells
) -> dict[str, tuple[Chance, Chance]]:
    """Kind → whether a term does anything anywhere: the largest root of F over all points, and the same `enhanced`.

    Of several kinds together it is the largest of theirs.

    Args:
        sizes: kind → (n, c) `local_sizes` at the points of the cells.
        design, term, part: as `term_fields`.
        cells: of the surface.
    """
    S, U, R, Q = _asked(sizes, design, term, part)
    E, free = S - R @ (R.T @ S), part.free - Q.shape[1]
    A, squares = Q.T @ U, np.square(E).sum(0)
    found = np.empty((len(sizes), 2, len(part.rows)))
    for some, T in permuted_products(E, Q, part.rows):
        t = _statistics(T, A, squares, free, bool(U.shape[1] == 1))
        for k, each in enumerate(np.split(t, len(sizes), axis=2)):
            found[k, :, some] = np.abs(each).max((1, 2)), _enhanced(each, cells).max((1, 2))
    return {kind: (Chance(of[0], part.exact), Chance(of[1], part.exact))
            for kind, of in zip(sizes, found, strict=True)}  # fmt: skip


def term_fields(
    sizes: Mapping[str, Float[np.ndarray, "n V"]],
    design: ModelDesign,
    term: ModelTerm,
    part: Stratum,
    mass: ArrayLike,
    cells: Cells,
) -> dict[str, list[PointField]]:
    """The fields of a term: kind → one a contrast, or the one of its F.

    The term is asked about beside all others but those that contain it, whatever the table does.

    Args:
        sizes: kind → (n, V) `local_sizes`.
        design: of the n shapes.
        term: of it.
        part: the stratum in which it is asked about.
        mass: (V,) area of each vertex.
    """
    S, U, R, Q = _asked(sizes, design, term, part)
    free = part.free - Q.shape[1]
    asked = [(c.title, weights(part, c.row)) for c in contrasts(design, term, PAIRS)]
    titles = [title for title, a in asked if a is not None]
    directions = [a for _, a in asked if a is not None]
    lengths = np.array([np.linalg.norm(a) for a in directions])
    E = S - R @ (R.T @ S)
    squares = np.square(E).sum(0)
    A = Q.T @ (np.stack(directions, 1) / lengths if directions else U)

    area = np.tile(np.asarray(mass, dtype=float), len(sizes))
    spots = np.concatenate([k * len(S.T) // len(sizes) + cells.chosen for k in range(len(sizes))])
    own = _statistics((Q.T @ E)[None], A, squares, free, bool(directions))[0]
    wide = np.concatenate([each @ cells.carry.T for each in np.split(_enhanced(own[None][:, :, spots], cells)[0],
                                                                     len(sizes), axis=1)], axis=1)  # fmt: skip
    own, widest = np.abs(own), np.empty(len(part.rows))
    null = _Null(own, area, len(part.rows))
    for some, T in permuted_products(E, Q, part.rows):
        found = _statistics(T, A, squares, free, bool(directions))
        null.add(some, np.abs(found))
        widest[some] = _enhanced(found[:, :, spots], cells).max((1, 2))
    p, false, border, p_enhanced = null.p(), null.false(), null.border(), _family_wise(wide, widest)
    kept = np.maximum(1 - np.square(np.median(null.largest) / np.maximum(own, np.finfo(float).tiny)), 0)
    fitted = S - Q @ (Q.T @ S)
    sigma = np.sqrt(np.square(fitted).sum(0) / free)
    made: dict[str, list[PointField]] = {kind: [] for kind in sizes}
    for k, title in enumerate(titles or [""]):
        if directions:
            effect, error = directions[k] @ S, lengths[k] * sigma
            reach = student.ppf(1 - LEVEL / 2, free) * error
            least = np.sign(effect) * np.maximum(np.abs(effect) - border * error, 0)
            statistic = effect / error
        else:
            effect, reach = np.sqrt(np.square(U.T @ S).sum(0) / len(S)), np.full(S.shape[1], np.nan)
            statistic = own[k]
            least = effect * np.maximum(1 - border / statistic, 0)
        values = (effect, effect - reach, effect + reach, statistic, p[k], p_enhanced[k], false[k], least,
                  effect * kept[k])  # fmt: skip
        for kind, split in zip(sizes, zip(*(np.split(v, len(sizes)) for v in values), strict=True), strict=True):
            made[kind].append(PointField(term.name, title, *split))
    return made


def _asked(
    sizes: Mapping[str, np.ndarray], design: ModelDesign, term: ModelTerm, part: Stratum
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sizes of the units of a stratum, and bases of what a term adds, of the model without it, of the whole model."""
    U, R = next((U, R) for name, U, R in bases(part, design, "II") if name == term.name)
    return part.carry @ np.concatenate(list(sizes.values()), axis=1), U, R, orthonormal(part.X)


def _statistics(T: np.ndarray, A: np.ndarray, squares: np.ndarray, free: int, each: bool) -> np.ndarray:
    """(M, K, V) t of contrasts, columns of A by themselves, or of (M, 1, V) the root of the F of all of them."""
    rest = np.maximum(squares - np.square(T).sum(1), np.finfo(float).tiny) / free
    along = np.matmul(A.T, T)
    if each:
        return along / np.sqrt(rest)[:, None]
    return np.sqrt(np.square(along).sum(1, keepdims=True) / A.shape[1] / rest[:, None])


def _enhanced(found: np.ndarray, cells: Cells) -> np.ndarray:
    """Of (M, K, c) of each kind side by side, every kind on a surface of its own."""
    return enhanced(found.reshape(-1, len(cells.chosen)), cells).reshape(found.shape)


def _family_wise(own: np.ndarray, largest: np.ndarray) -> np.ndarray:
    ordered = np.sort(largest)
    return 1 - np.searchsorted(ordered, own * (1 - SAME), side="left") / len(ordered)


class _Null:
    """The largest statistic anywhere of each permutation, and how much of the area is above each of some levels."""

    def __init__(self, own: np.ndarray, area: np.ndarray, permutations: int):
        self.own, self.area = own, np.broadcast_to(area, own.shape)
        self.largest = np.empty(permutations)
        self.levels = np.quantile(own, np.linspace(0, 1, 512))
        self.above, self.drawn = np.zeros(len(self.levels) + 1), 0

    def add(self, some: slice, found: np.ndarray) -> None:
        self.largest[some] = found.max((1, 2))
        others = found[1:] if some.start == 0 else found  # the data are no chance
        for one in others[: max(0, DRAWN - self.drawn)]:
            places = np.searchsorted(self.levels, one.ravel(), side="right")
            self.above += np.bincount(places, self.area.ravel(), len(self.levels) + 1)
            self.drawn += 1

    def p(self) -> np.ndarray:
        return _family_wise(self.own, self.largest)

    def border(self) -> float:
        """The least statistic with a family-wise p of 5 %."""
        at = sorted(self.largest.tolist())[int(np.ceil((1 - LEVEL) * len(self.largest))) - 1 :]
        return next((value for value in at if reached(self.largest, value).mean() <= LEVEL), np.inf)

    def false(self) -> np.ndarray:
        """By steps from level to level: never more for a larger statistic."""
        if not self.drawn:
            return np.ones(self.own.shape)
        expected = np.cumsum(self.above[::-1])[::-1][1:] / self.drawn
        places = np.searchsorted(self.levels, self.own.ravel(), side="right")
        seen = np.cumsum(np.bincount(places, self.area.ravel(), len(self.levels) + 1)[::-1])[::-1][1:]
        shares = np.minimum.accumulate(np.minimum(expected / np.maximum(seen, np.finfo(float).tiny), 1))
        return shares[np.clip(places - 1, 0, None)].reshape(self.own.shape)
