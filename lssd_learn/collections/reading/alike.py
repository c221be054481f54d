"""Shapes with the same faces: are they in vertex correspondence? Their edges tell. Used by `folder.py`."""

from collections.abc import Sequence

import numpy as np

from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import some_of
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.edges import edge_lengths, edges

# The standard deviation of log ratios of edge lengths, scale aside: .06 to .2 between bodies and faces of all kinds and
# poses, .1 to .32 between spheres bent at random, .5 and more where vertices are permuted.
UNLIKE = 0.4
KINDS = 8  # of shapes with the same faces and edges that are not alike: more are not told apart


class SameFaces:
    """Takes one shape after another, and says which are taken to be in vertex correspondence.

    Args:
        names: of the shapes.
        told: takes what is found.
    """

    def __init__(self, names: Sequence[str], told: Told):
        self._names, self._told = names, told
        self._kinds: dict[str, list[tuple[np.ndarray, list[int]]]] = {}
        self._edges: dict[str, np.ndarray] = {}

    def add(self, i: int, mesh: Mesh) -> None:
        """Shape i."""
        kinds = self._kinds.setdefault(mesh.connectivity, [])
        if mesh.connectivity not in self._edges:
            self._edges[mesh.connectivity] = edges(mesh.faces)
        lengths = edge_lengths(mesh.vertices, self._edges[mesh.connectivity])
        logs = np.log(np.maximum(lengths, 1e-12 * lengths.max())).astype(np.float32)
        for known, members in kinds:
            if np.std(logs - known) <= UNLIKE or len(kinds) == KINDS:
                members.append(i)
                return
        kinds.append((logs, [i]))

    def tell(self) -> None:
        """Say of the first two of the same faces that they are taken to correspond, and warn of those unlike them."""
        several = [kinds for kinds in self._kinds.values() if sum(len(members) for _, members in kinds) > 1]
        if several:
            first, second, *_ = sorted(i for _, members in several[0] for i in members)
            self._told.say(
                f"{self._names[first]} and {self._names[second]} have the same faces: such shapes are taken to be in "
                "vertex correspondence (collection.correspondence=none forbids it)"
            )
        for kinds in several:
            most_logs, most = max(kinds, key=lambda kind: len(kind[1]))
            for logs, members in kinds:
                if members is not most:
                    who = some_of([self._names[i] for i in members], 1)
                    self._told.warn(
                        f"{who}: the same faces as {self._names[most[0]]}, but edges "
                        f"that are not alike (by a factor of {np.exp(np.std(logs - most_logs)):.2g}): likely not in "
                        "vertex correspondence, though taken to be (collection.correspondence=none forbids it)"
                    )
