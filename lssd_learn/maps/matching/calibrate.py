"""Where the numbers of `measures.py` come from: `python -m lssd_learn.maps.matching.calibrate` prints them.

Generated bodies in random poses, each with a mesh of its own, are matched from several starts. The weights of `score`
are those that most clearly choose the best map of a pair; `quality` is a model of whether the chosen map is good, the
product of two logistic curves, fitted to these choices, to those that would be made if the right map had not been
found, and to maps between bodies and bumped spheres, of which none is right.
"""

import argparse
from pathlib import Path
from typing import cast

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logsumexp

from lssd_learn.collections import Bodies, Bumps, Remeshed
from lssd_learn.maps.matching.bending import Bent
from lssd_learn.maps.matching.candidates import candidates
from lssd_learn.maps.matching.measures import TINY, Measures
from lssd_learn.maps.matching.prepared import Prepared, prepared
from lssd_learn.maps.quality import geodesic_errors
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape, eigenbasis
from lssd_learn.written import write_arrays

GOOD = 0.05  # mean error over √area that is still good
PRIOR = 0.02  # strength of the prior on weights
USED = ("energy", "trip", "unlike", "facing")  # measures; the others depend on how fine the meshes are
RARE = 0.4  # weight of a choice without the right map
POINTS = 100  # vertices scored a map
HEIGHTS = [[0.5, 0.2], [0.3, 0.5], [0.6, 0.0], [0.2, 0.4]]  # of the bumps of spheres


def maps_of(pairs: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(pairs, n, d) measures and (pairs, n) true mean errors over √area of the maps from n starts."""
    bodies = _bodies(pairs, seed)
    order = np.random.default_rng(seed).permutation(2 * pairs).reshape(pairs, 2)
    seen, errors = [], []
    for i, j in track([tuple(pair) for pair in order.tolist()], "pairs"):
        found = candidates(_ready(bodies[i]), _ready(bodies[j]), every=True)
        true = bodies.vertex_maps[i, j]
        some = np.random.default_rng(0).permutation(len(true))[:POINTS]
        maps = np.concatenate([way.there[some] for way, _ in found])
        away = geodesic_errors(bodies[i], maps, np.tile(true[some], len(found)))
        seen.append(_row(found))
        errors.append(away.reshape(len(found), -1).mean(axis=1))
    return np.array(seen), np.array(errors)


def wrong_maps(seed: int) -> np.ndarray:
    """(m, n, d) measures of maps from n starts between bodies and m bumped spheres."""
    bodies, spheres = _bodies(len(HEIGHTS), seed), Bumps(heights=HEIGHTS, groups={})
    pairs = [(bodies[i], spheres[i]) for i in range(len(HEIGHTS))]
    return np.array([_row(candidates(_ready(a), _ready(b), every=True)) for a, b in track(pairs, "wrong pairs")])


def _bodies(pairs: int, seed: int) -> Remeshed:
    return Remeshed(Bodies(n=2 * pairs, seed=seed, jitter=25, poses="random"), vertices=(1500, 2500), seed=seed)


def _ready(mesh: Shape) -> Prepared:
    return prepared(cast(Mesh, mesh), eigenbasis(mesh, 80))


def _row(found: list[tuple[Bent, Measures]]) -> list[list[float]]:
    return [[getattr(measured, name) for name in USED] for _, measured in found]


def choice_weights(seen: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """(d,) weights, none positive, of logarithms of measures: a conditional logit on which map of a pair is best."""
    x, usable = np.log(seen + TINY), (errors < GOOD).any(axis=1)
    scale = x.reshape(-1, x.shape[2]).std(axis=0)
    z, best = x[usable] / scale, errors[usable].argmin(axis=1)

    def loss(weights):
        u = z @ weights
        return (logsumexp(u, axis=1) - u[np.arange(len(u)), best]).mean() + PRIOR * (weights**2).sum()

    return minimize(loss, np.zeros(x.shape[2]), bounds=[(None, 0)] * x.shape[2]).x / scale


def quality_numbers(scores: np.ndarray, errors: np.ndarray, wrong: np.ndarray) -> np.ndarray:
    """(4,) LEVEL, STEEP, LEAD and TELLING of `measures.quality`, by their likelihood on chosen maps.

    Args:
        scores, errors: (pairs, n) of maps.
        wrong: (m, n) scores of maps between shapes that have none.
    """
    rows, good, weights = [], [], []
    for these, away in zip(scores, errors, strict=True):
        without = np.flatnonzero(away >= GOOD)
        for kept, weight in ((np.arange(len(these)), 1.0), (without, RARE if len(without) < len(these) else 0.0)):
            order = kept[np.argsort(-these[kept])]
            if len(order) > 1:
                rows.append([these[order[0]], these[order[0]] - these[order[1]]])
                good.append(away[order[0]] < GOOD)
                weights.append(weight)
    for these in -np.sort(-wrong, axis=1):
        rows.append([these[0], these[0] - these[1]])
        good.append(False)
        weights.append(RARE)
    x, side, share = np.array(rows), np.array(good), np.array(weights) / np.sum(weights)
    middle, scale = x.mean(axis=0), x.std(axis=0)

    def loss(numbers):
        away = numbers[[1, 3]] * ((x - middle) / scale - numbers[[0, 2]])
        sure = -np.logaddexp(0, -away).sum(axis=1)  # the logarithm of the quality
        told = np.where(side, sure, np.log(-np.expm1(np.minimum(sure, -TINY))))
        return -share @ told + PRIOR / 10 * (numbers[[1, 3]] ** 2).sum()

    found = minimize(loss, [-1, 1, -1, 1], bounds=[(None, None), (0, None)] * 2).x
    level, lead = middle + scale * found[[0, 2]]
    steep, telling = found[[1, 3]] / scale
    return np.array([level, steep, lead, telling])


def main() -> None:
    """Print the numbers, and what becomes of the maps they were fitted to."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--file", type=Path, help="where measures are kept, and read from if they are there")
    given = parser.parse_args()
    if given.file and given.file.exists():
        kept = np.load(given.file)
        seen, errors, wrong = kept["seen"], kept["errors"], kept["wrong"]
    else:
        seen, errors, wrong = *maps_of(given.pairs, given.seed), wrong_maps(given.seed)
        if given.file:
            write_arrays({"seen": seen, "errors": errors, "wrong": wrong}, given.file)
    weights = choice_weights(seen, errors)
    scores = np.log(seen + TINY) @ weights
    numbers = quality_numbers(scores, errors, np.log(wrong + TINY) @ weights)
    print("WEIGHTS =", {name: round(float(w), 2) for name, w in zip(USED, weights, strict=True)})
    print("LEVEL, STEEP, LEAD, TELLING =", numbers.round(3).tolist())
    ranked = -np.sort(-scores, axis=1)
    level, steep, lead, telling = numbers
    trusted = expit(steep * (ranked[:, 0] - level)) * expit(telling * (ranked[:, 0] - ranked[:, 1] - lead)) > 0.5
    good = errors[np.arange(len(errors)), scores.argmax(axis=1)] < GOOD
    print(f"{len(good)} pairs, {good.sum()} well matched")
    print(f"trusted {trusted.sum()}, of them bad {(trusted & ~good).sum()}")
    print(f"not trusted {(~trusted).sum()}, of them bad {(~trusted & ~good).sum()}")


if __name__ == "__main__":
    main()
