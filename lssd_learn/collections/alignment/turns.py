"""From how pairs of shapes lie on each other to how all lie in one frame: the pairs, the sides, the turns, the shifts.

Pure functions on arrays, for `aligned.py`. A pose of shape i is `x @ P_i + u_i`; a pair (i, j) says that `x_i @ Q + t`
lies on x_j, so that P_i = Q P_j.
"""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from lssd_learn.shapes.closest_points import angles
from lssd_learn.shapes.kabsch import nearest_orthogonal

CYCLES = 3  # through all shapes, each in an order of its own: every shape is laid on six others
WIDE = 5.0  # degrees off the others from which a pair counts for less
ROUNDS, SETTLED = 200, 1e-9


def sparse_pairs(n: int, seed: int = 0) -> Int[np.ndarray, "m 2"]:
    """(m, 2) pairs i < j of n shapes that hold all together: every pair of seven or fewer, else random cycles."""
    if n <= 2 * CYCLES + 1:
        return np.stack(np.triu_indices(n, 1), axis=1)
    rng = np.random.default_rng(seed)
    orders = [rng.permutation(n) for _ in range(CYCLES)]
    ends = np.concatenate([np.stack([order, np.roll(order, 1)], axis=1) for order in orders])
    return np.unique(np.sort(ends, axis=1), axis=0)


def sides(n: int, pairs: Int[np.ndarray, "m 2"], evidence: Float[np.ndarray, " m"]) -> Int[np.ndarray, " n"]:
    """(n,) 1 or −1: shapes of one sign are of one side.

    Args:
        evidence: (m,) of each pair, positive where both are of one side; by how much it counts.
    """
    side = np.ones(n, dtype=int)
    for i, parent, pair in _tree(n, pairs, 1 / (1e-9 + np.abs(evidence))):
        side[i] = side[parent] * (1 if evidence[pair] >= 0 else -1)
    while True:  # each turn lessens what speaks against the sides, so it ends
        support = side * _sums(n, pairs, evidence * side[pairs[:, 1]], evidence * side[pairs[:, 0]])
        worst = int(support.argmin())
        if support[worst] >= -1e-12:
            return side
        side[worst] *= -1


def turns(
    n: int, pairs: Int[np.ndarray, "m 2"], Q: Float[np.ndarray, "m 3 3"], residuals: Float[np.ndarray, " m"]
) -> Float[np.ndarray, "n 3 3"]:
    """(n, 3, 3) orthogonal P with P_i ≈ Q_ij P_j, up to one turn of all.

    Along a spanning tree of the best pairs first, then averaged over all pairs, where those that are far off count for
    little (after Hartley, Trumpf, Dai and Li, "Rotation averaging", International Journal of Computer Vision 103, 2013,
    with a weight that falls off faster): one pair that is wrong turns nothing.

    Args:
        Q: (m, 3, 3); residuals: (m,) how well each pair fits.
    """
    P = np.tile(np.eye(3), (n, 1, 1))
    for i, parent, pair in _tree(n, pairs, residuals):
        P[i] = (Q[pair] if pairs[pair, 0] == i else Q[pair].T) @ P[parent]
    a, b = pairs.T
    trust = 1 / np.square(np.maximum(residuals, 1e-9 + 0.1 * np.median(residuals)))
    trust = trust / trust.max()
    for number in range(ROUNDS):
        off = angles_between(P[a], Q @ P[b]) / WIDE
        # Gently first, so that what the tree has wrong can still be pulled right, and then regardless of what is far.
        w = (trust / (1 + off if 2 * number < ROUNDS else np.square(1 + np.square(off))))[:, None, None]
        ahead, back = w * (Q @ P[b]), w * (Q.transpose(0, 2, 1) @ P[a])
        total = _sums(n, pairs, ahead, back)
        weight = _sums(n, pairs, w, w)
        before, P = P, nearest_orthogonal(total + (weight + 1e-12) * P)  # damped: two shapes would change places
        if 2 * number > ROUNDS and np.abs(P - before).max() < SETTLED:
            break
    return P


def shifts(
    n: int,
    pairs: Int[np.ndarray, "m 2"],
    P: Float[np.ndarray, "n 3 3"],
    t: Float[np.ndarray, "m 3"],
    weights: Float[np.ndarray, " m"],
) -> Float[np.ndarray, "n 3"]:
    """(n, 3) u of least Σ w ‖u_i − u_j − t_ij P_j‖², the least of them."""
    a, b = pairs.T
    wanted = np.einsum("mx,mxy->my", t, P[b])
    w = weights / weights.max()
    L = np.zeros((n, n))
    np.add.at(L, (a, a), w), np.add.at(L, (b, b), w)
    np.add.at(L, (a, b), -w), np.add.at(L, (b, a), -w)
    right = _sums(n, pairs, w[:, None] * wanted, -w[:, None] * wanted)
    return np.linalg.lstsq(L, right, rcond=None)[0]


def reached(n: int, pairs: Int[np.ndarray, "m 2"], good: Bool[np.ndarray, " m"]) -> Bool[np.ndarray, " n"]:
    """(n,) bool: the most shapes that hold together by pairs that are `good` (m,)."""
    a, b = pairs[good].T
    of = connected_components(csr_array((np.ones(len(a)), (a, b)), shape=(n, n)), directed=False)[1]
    return of == np.bincount(of).argmax()


def angles_between(P: Float[np.ndarray, "*#some 3 3"], R: Float[np.ndarray, "*#some 3 3"]) -> Float[np.ndarray, "..."]:
    """(…) degrees from one to the other of orthogonal matrices (…, 3, 3) of one determinant; 180 of two."""
    between = np.swapaxes(P, -1, -2) @ R
    return np.where(np.linalg.det(between) > 0, angles(between), 180.0)


def medians(
    n: int, pairs: Int[np.ndarray, "m 2"], first: Float[np.ndarray, " m"], second: Float[np.ndarray, " m"]
) -> Float[np.ndarray, " n"]:
    """(n,) the median over the pairs of each shape: of `first` (m,) where it is the first, else of `second`."""
    own = [np.concatenate([first[pairs[:, 0] == i], second[pairs[:, 1] == i]]) for i in range(n)]
    return np.array([np.median(values) if len(values) else np.nan for values in own])


def _tree(n: int, pairs: Int[np.ndarray, "m 2"], costs: Float[np.ndarray, " m"]) -> list[tuple[int, int, int]]:
    """(shape, parent, pair) of a spanning tree of least cost, parents first."""
    a, b = pairs.T.astype(np.int32)  # the numbers that scipy before 1.17 wants in a graph
    dense = csr_array((costs + 1e-12, (a, b)), shape=(n, n))
    number = csr_array((np.arange(1, len(pairs) + 1), (a, b)), shape=(n, n)).todok()
    tree = minimum_spanning_tree(dense)
    order, parents = breadth_first_order(tree, 0, directed=False)
    return [(int(i), int(p), int(number[min(i, p), max(i, p)]) - 1)
            for i, p in ((i, parents[i]) for i in order[1:])]  # fmt: skip


def _sums(
    n: int, pairs: Int[np.ndarray, "m 2"], first: Float[np.ndarray, "m ..."], second: Float[np.ndarray, "m ..."]
) -> Float[np.ndarray, "n ..."]:
    """(n, …) sums over the pairs of each shape: `first` (m, …) where it is the first of a pair, else `second`."""
    out = np.zeros((n, *first.shape[1:]))
    np.add.at(out, pairs[:, 0], first)
    np.add.at(out, pairs[:, 1], second)
    return out
