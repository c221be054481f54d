"""Third step of matching: rough matches, from every sensible way to assign ends to ends, the likeliest first."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from lssd_learn.maps.matching.features import Features
from lssd_learn.maps.matching.prepared import MAIN, Prepared
from lssd_learn.maps.matching.spectral import fitted, nearest

LIKELY, TRIED = 16, 8  # assignments beside those of main ends to main ends, and ones that are refined
FEW, SOME = 300, 600  # points of these two
REACH = 0.15  # weight of unlike reaches against unlike distances between ends
PLAIN, SIDED = 0.3, 0.15  # weights of the descriptors against paths
SIZES = range(20, 51, 6)  # functions of the rounds
FADE = 3  # rounds in which descriptors still count


@dataclass(frozen=True, eq=False)
class Start:
    """A rough map.

    Attributes:
        C: (k, k) carries functions on the source to functions on the target.
        measures: see `_measures`; the smaller the better.
    """

    C: np.ndarray
    measures: np.ndarray

    @property
    def badness(self) -> float:
        """One number of the measures."""
        return float(self.measures @ WEIGHTS)


# Of what is left of the features, one minus the agreement of the sided ones, distance of C from an isometry.
WEIGHTS = np.array([1.0, 0.2, 0.2])


def starts(source: Prepared, target: Prepared, looks: tuple[Features, Features]) -> list[Start]:
    """Rough maps, the best first.

    Ends are assigned so that distances among them agree, points are matched by their distances to these ends and their
    looks, and the match is carried over to eigenfunctions while looks count less and less.

    Args:
        source, target: the two shapes.
        looks: see `features`.
    """
    pairs = _assignments(source, target)
    places = [_places(source, target, looks, pair, FEW) for pair in pairs]
    left = [_left(A, B, nearest(A, B)) for A, B, _, _ in places]
    chosen = [pairs[n] for n in np.argsort(left, kind="stable")[:TRIED]]
    found = [_refined(source, target, looks, pair) for pair in chosen]
    return sorted(found, key=lambda start: start.badness)


def _assignments(source: Prepared, target: Prepared) -> list[tuple[np.ndarray, np.ndarray]]:
    """Numbers of ends of the source and of those of the target they are assigned to, the likeliest first.

    The main ends of the source go to any of the target's, and the other way round; main ones to main ones in every
    order.
    """
    forth = _ways(source, target)
    back = [(cost, here, there) for cost, there, here in _ways(target, source)]
    ways, seen = [], set()
    for _, here, there in sorted(forth + back, key=lambda way: way[0]):
        name = tuple(sorted(zip(here.tolist(), there.tolist(), strict=True)))
        if name not in seen:
            seen.add(name)
            ways.append((here, there))
    main = [way for way in ways if max(way[0].max(), way[1].max()) < MAIN]
    return main + [way for way in ways if max(way[0].max(), way[1].max()) >= MAIN][:LIKELY]


def _ways(source: Prepared, target: Prepared) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """(cost, ends of the source, ends of the target) of every way, the likeliest first."""
    here = np.arange(MAIN)
    there = np.array(list(permutations(range(len(target.ends)), len(here))))
    among = source.paths[:, source.ends][np.ix_(here, here)]
    others = target.paths[:, target.ends][there[:, :, None], there[:, None, :]]
    unlike = np.abs(among - others) / np.maximum(among + others, np.finfo(float).tiny)
    first, second = np.triu_indices(len(here), 1)
    reach = np.abs(source.reach[source.ends][here] - target.reach[target.ends][there])
    costs = unlike[:, first, second].mean(axis=1) + REACH * reach.mean(axis=1)
    return [(float(costs[n]), here, there[n]) for n in np.argsort(costs, kind="stable")]


def _places(source: Prepared, target: Prepared, looks: tuple[Features, Features], pair: tuple, count: int) -> tuple:
    """Where sample points are, by their distances to the assigned ends and their looks, and which points they are."""
    found, points = [], []
    for shape, look, ends in zip((source, target), looks, pair, strict=True):
        some = shape.samples[:count]
        columns = [shape.paths[ends][:, some].T, PLAIN * look.plain[some], SIDED * look.sided[some]]
        found.append(np.hstack(columns).astype(np.float32))
        points.append(some)
    return *found, *points


def _left(A: np.ndarray, B: np.ndarray, there: np.ndarray) -> float:
    """The mean distance of matched rows."""
    return float(np.sqrt(((A[there] - B) ** 2).sum(axis=1)).mean())


def _refined(source: Prepared, target: Prepared, looks: tuple[Features, Features], pair: tuple) -> Start:
    """One assignment, carried over to eigenfunctions."""
    A, B, s, t = _places(source, target, looks, pair, SOME)
    S, T = source.embedding[s], target.embedding[t]
    there, scale = nearest(A, B), 2 * A.std(axis=0).max()
    most = min(source.basis.k, target.basis.k)
    for number, k in enumerate(k for k in SIZES if k <= most):
        C = fitted(T[:, :k], S[there, :k])
        weight = np.float32(np.sqrt(k) * max(0, 1 - number / FADE) / scale)
        there = nearest(np.hstack([S[:, :k], weight * A]), np.hstack([T[:, :k] @ C, weight * B]))
    mine, theirs = looks[0].sided[s][there], looks[1].sided[t]
    agreement = (mine * theirs).sum() / np.sqrt((mine**2).sum() * (theirs**2).sum())
    skew = np.linalg.norm(C.T @ C - np.eye(len(C))) / np.sqrt(len(C))
    return Start(C, np.array([_left(A, B, there), 1 - agreement, skew]))
