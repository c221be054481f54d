"""Where the numbers of `measures.quality` come from: `python -m lssd_learn.maps.matching.calibrate` prints them.

Generated bodies in random poses, each with a mesh of its own, are matched from several starts, right and wrong, and a
logistic model of "the mean error is below 5 % of √area" is fitted to the measures of all these maps.
"""

import argparse
from dataclasses import astuple

import numpy as np
from scipy.optimize import minimize

from lssd_learn.collections import Bodies, Remeshed
from lssd_learn.maps.matching.bending import bent, laid, roughly
from lssd_learn.maps.matching.features import features
from lssd_learn.maps.matching.lattice import lattices
from lssd_learn.maps.matching.measures import TINY, measures
from lssd_learn.maps.matching.prepared import prepared
from lssd_learn.maps.matching.spectral import zoomed
from lssd_learn.maps.matching.starts import starts
from lssd_learn.maps.quality import geodesic_errors
from lssd_learn.progress import track
from lssd_learn.shapes import eigenbasis

GOOD = 0.05  # mean error over √area that is still good
PLAIN = 0.03  # strength of the prior on weights, a share of the mean loss
STARTS, POINTS = 4, 200  # starts a pair, and vertices scored a map


def maps_of(pairs: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(m, d) measures and (m,) true mean errors over √area of the maps from several starts of so many pairs."""
    bodies = Remeshed(Bodies(n=2 * pairs, seed=seed, jitter=25), vertices=(2500, 4000), seed=seed)
    order = np.random.default_rng(seed).permutation(2 * pairs).reshape(pairs, 2)
    seen, errors = [], []
    for i, j in track([tuple(pair) for pair in order.tolist()], "pairs"):
        source, target = (prepared(bodies[k], eigenbasis(bodies[k], 80)) for k in (i, j))
        looks, nets, true = features(source, target), lattices(source), bodies.vertex_maps[i, j]
        some = np.random.default_rng(0).permutation(len(true))[:POINTS]
        for start in starts(source, target, looks)[:STARTS]:
            way = laid(source, target, *zoomed(source, target, start.C))
            for level in range(len(nets)):
                way = roughly(nets, level, target, way)
            found = bent(source, target, way)
            seen.append(astuple(measures(source, target, looks, found)))
            errors.append(geodesic_errors(source.shape, found.there[some], true[some]).mean())
    return np.array(seen), np.array(errors)


def fitted_quality(seen: np.ndarray, errors: np.ndarray) -> tuple[float, np.ndarray]:
    """Constant and weights (d,), none positive, of a logistic model on logarithms of the measures.

    Good and bad maps count as much, each kind together.
    """
    x, good = np.log(seen + TINY), errors < GOOD
    middle, scale = x.mean(axis=0), x.std(axis=0)
    z, side = (x - middle) / scale, np.where(good, 1, -1)
    share = np.where(good, 0.5 / good.sum(), 0.5 / (~good).sum())

    def loss(parameters):
        margin = side * (parameters[0] + z @ parameters[1:])
        return share @ np.logaddexp(0, -margin) + PLAIN / 2 * (parameters[1:] ** 2).sum()

    bounds = [(None, None)] + [(None, 0)] * x.shape[1]
    best = minimize(loss, np.zeros(1 + x.shape[1]), method="L-BFGS-B", bounds=bounds).x
    weights = best[1:] / scale
    return float(best[0] - weights @ middle), weights


def main() -> None:
    """Print the constant and the weights, and how they do on other pairs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--save")
    given = parser.parse_args()
    seen, errors = maps_of(given.pairs, given.seed)
    if given.save:
        np.savez(given.save, seen=seen, errors=errors)
    constant, weights = fitted_quality(seen, errors)
    right = ((constant + np.log(seen + TINY) @ weights > 0) == (errors < GOOD)).mean()
    print(f"CONSTANT = {constant:.2f}\nWEIGHTS = ({', '.join(f'{w:.2f}' for w in weights)})")
    print(f"{len(errors)} maps, {(errors < GOOD).sum()} good, {right:.3f} told right")


if __name__ == "__main__":
    main()
