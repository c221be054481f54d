"""One computed map against the true one, and which pairs of a collection are scored: for the tasks that judge maps."""

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn import maps
from lssd_learn.collections import Benchmark, Bodies, Collection, Remeshed
from lssd_learn.collections.parallel import on_one_thread
from lssd_learn.maps import ComputedMaps
from lssd_learn.shapes import Mesh


@dataclass(frozen=True)
class Entry:
    """What a method has computed of a pair.

    Attributes:
        there, back: vertices, see `ComputedMaps.vertex_maps`.
        quality: what the method itself says of it, in [0, 1]; None where it says nothing.
        seconds: of processor time.
    """

    there: np.ndarray
    back: np.ndarray
    quality: float | None
    seconds: float

    @classmethod
    def compute(cls, maker: ComputedMaps, i: int, j: int) -> "Entry":
        """Of shapes i and j, i < j, on one thread; the two are made beforehand, so that no time holds it."""
        _ = maker.shapes[i], maker.shapes[j]
        start = time.process_time()
        kept = on_one_thread(maker.pair, i, j)
        seconds = time.process_time() - start
        quality = None if "quality" not in kept else float(kept["quality"])
        return cls(kept["there"], kept["back"], quality, seconds)


def score(
    entry: Entry, collection: Collection, i: int, j: int, points: int | None
) -> tuple[dict[str, float], Float[np.ndarray, " m"]]:
    """How good a map of a pair is, from shape i to shape j.

    Args:
        entry: of the pair.
        collection: whose true maps are known.
        i, j: source and target.
        points: of the target that are scored, drawn at random; None is all that are known.

    Returns:
        "error", the mean geodesic error over √area; "flipped", of bodies, the share of vertices on the wrong side;
        "turned", of meshes, the share of the target's area that turns over; "seconds" and "quality". And (m,) the
        errors.
    """
    found, (here, there) = entry.there if i < j else entry.back, true_points(collection, i, j)
    some = np.random.default_rng(0).permutation(len(there))[:points]
    errors = maps.geodesic_errors(collection[i], found[there[some]], here[some])
    row = {"error": float(errors.mean())}
    if (side := _side(collection, i)) is not None:
        row["flipped"] = maps.flipped(side, found[there], here)
    if isinstance(source := collection[i], Mesh) and isinstance(target := collection[j], Mesh):
        row["turned"] = maps.turned_over(source, target, found)
    row["seconds"] = entry.seconds
    return row | ({} if entry.quality is None else {"quality": entry.quality}), errors


def true_points(collection: Collection, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    """(m,) vertices of shape i and (m,) the same points on shape j."""
    if isinstance(collection, Benchmark):
        return collection.known(i, j)
    here = collection.vertex_maps[i, j]
    return here, np.arange(len(here))


def _side(collection: Collection, i: int) -> np.ndarray | None:
    """(V_i,) how far to the left a vertex of a body lies: in the rest pose left and right are one coordinate."""
    if not (isinstance(collection, Remeshed) and isinstance(collection.base, Bodies)):
        return None
    return collection.base.make({}).vertices[collection.origins(i), 0]


def pairs_by(collection: Collection, group: str, count: int, rng: np.random.Generator) -> list[tuple[str, int, int]]:
    """(kind, source, target) of at most `count` pairs with one label, "same_GROUP", and as many of two, "other_GROUP".

    Args:
        collection: with that group.
        group: its name.
        count: of each kind.
        rng: what draws them, each once in one of its directions.
    """
    labels = np.asarray(collection.groups[group])
    first, second = np.triu_indices(len(labels), 1)
    pairs: list[tuple[str, int, int]] = []
    for kind, same in ((f"same_{group}", True), (f"other_{group}", False)):
        fit = np.flatnonzero((labels[first] == labels[second]) == same)
        drawn = rng.permutation(fit)[:count]
        ways = rng.permuted(np.stack([first[drawn], second[drawn]], axis=1), axis=1)
        pairs += [(kind, int(i), int(j)) for i, j in ways]
    return pairs
