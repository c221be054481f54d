"""The minimum spanning tree of points, without the distances of all pairs (Borůvka 1926, with k-d trees)."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.latent.graphs.near import Search, Turned, by_place, nearest

NEIGHBOURS = 12  # that most of the tree is found among


def spanning_tree(points: Float[np.ndarray, "n d"]) -> Int[np.ndarray, "m 2"]:
    """(n - 1, 2) the edges of a minimum spanning tree of points (n, d).

    Points that are there twice are joined to the first of them. Where other distances are equal there are several such
    trees; one of them is found, the same every time.
    """
    points = np.asarray(points, dtype=float)
    _, first, which = np.unique(points, axis=0, return_index=True, return_inverse=True)
    which = first[which.ravel()]
    again = np.flatnonzero(which != np.arange(len(points)))
    once = np.sort(first)
    return np.concatenate([np.stack([which[again], again], axis=1), once[_Forest(points[once]).joined()]])


class _Forest:
    """Trees that grow together: in each round every tree but the largest is joined to another by its shortest edge out.

    Args:
        points: no two of them equal.
    """

    def __init__(self, points: Float[np.ndarray, "n d"]):
        self._points, self._space = points, Turned(points)
        n = len(points)
        self._tree_of = np.arange(n)
        self._near, self._away = nearest(points, points, min(NEIGHBOURS, n - 1), own=True)
        # The nearest point of another tree, as far as it has been asked for: while it is in another one, it stays so.
        self._out, self._length = np.full(n, -1), np.full(n, np.inf)

    def joined(self) -> Int[np.ndarray, "m 2"]:
        """(n - 1, 2) the edges."""
        edges = [np.empty((0, 2), dtype=np.int64)]
        while self._tree_of.max(initial=0) > 0:
            edges.append(self._join(self._shortest()))
        return np.concatenate(edges)

    def _shortest(self) -> Int[np.ndarray, " p"]:
        """(p,) one point of each tree that is to be joined: the one with its shortest edge out."""
        trees, here = self._tree_of, np.arange(len(self._points))
        foreign = trees[self._near] != trees[:, None]
        known, which = foreign.any(axis=1), foreign.argmax(axis=1)
        self._out[known] = self._near[here, which][known]
        self._length[known] = self._away[here, which][known]
        known |= (self._out >= 0) & (trees[self._out] != trees)
        self._length[~known] = np.inf
        least = np.full(trees.max() + 1, np.inf)
        np.minimum.at(least, trees, self._length)
        # Of the others only these could have a shorter one: all their listed neighbours are of their own tree.
        asked = ~known & (self._away[:, -1] <= least[trees])
        largest = np.bincount(trees).argmax()
        skipped = asked & (trees == largest)
        asked &= ~skipped
        self._ask(np.flatnonzero(asked))
        order = np.lexsort((self._high(), self._low(), self._length, trees))
        firsts = order[np.unique(trees[order], return_index=True)[1]]
        return firsts[(trees[firsts] != largest) | ~skipped.any()]

    def _low(self) -> Int[np.ndarray, " n"]:
        return np.minimum(self._out, np.arange(len(self._out)))

    def _high(self) -> Int[np.ndarray, " n"]:
        return np.maximum(self._out, np.arange(len(self._out)))

    def _ask(self, asked: Int[np.ndarray, " a"]) -> None:
        """The nearest point of another tree for each of these: the numbers of two trees differ in a binary digit."""
        trees, turned = self._tree_of, self._space.points
        self._length[asked] = np.inf
        asked = asked[by_place(turned[asked])] if len(asked) else asked
        for digit in range(int(trees.max()).bit_length() if len(asked) else 0):
            side = (trees >> digit) & 1
            for value in (0, 1):
                ours, theirs = asked[side[asked] == value], np.flatnonzero(side != value)
                if not len(ours):
                    continue
                found = theirs[Search(turned[theirs]).query(turned[ours])[1]]
                away = np.linalg.norm(self._points[ours] - self._points[found], axis=1)
                better = away < self._length[ours]
                self._length[ours[better]], self._out[ours[better]] = away[better], found[better]

    def _join(self, firsts: Int[np.ndarray, " p"]) -> Int[np.ndarray, "m 2"]:
        """The edges out of these points, but for one of each cycle of equal ones; their trees become one."""
        parent = list(range(self._tree_of.max() + 1))

        def root(tree: int) -> int:
            while parent[tree] != tree:
                parent[tree] = parent[parent[tree]]
                tree = parent[tree]
            return tree

        kept = []
        order = np.lexsort((self._high()[firsts], self._low()[firsts], self._length[firsts]))
        for i in firsts[order].tolist():
            a, b = root(int(self._tree_of[i])), root(int(self._tree_of[self._out[i]]))
            if a != b:
                parent[a] = b
                kept.append((i, self._out[i]))
        roots = np.array([root(tree) for tree in range(len(parent))])
        self._tree_of = np.unique(roots, return_inverse=True)[1].ravel()[self._tree_of]
        return np.array(kept, dtype=np.int64).reshape(-1, 2)
