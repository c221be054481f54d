"""Fourth step: many new shapes as mixtures of known ones, in parallel, each kept in the cache where there is one."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.maps.span.spanned import CLEAR, LEAST, VERSION, Alike, Spanned, spanned
from lssd_learn.shapes import Eigenbasis, Mesh
from lssd_learn.shapes.rigid import rigid

STAGE = "mixtures"


@dataclass(frozen=True, eq=False)
class Starts:
    """Where the mixtures begin.

    Attributes:
        known, strangers: n and m shapes.
        bases: the eigenbases of the known ones.
        maps: of both, the known first.
        chosen: (m,) of each new one some known shapes that are like it, the likest first.
        own: (m,) the known shape that each new one is not to be made of, −1 where there is none.
    """

    known: Collection
    strangers: Collection
    bases: Sequence[Eigenbasis]
    maps: PairMaps
    chosen: Sequence[Sequence[int]]
    own: Sequence[int]

    @cached_property
    def alike(self) -> dict[str, Alike]:
        """The known shapes by their faces, where enough of them share these."""
        kinds = np.array([str(self.bases[i].connectivity) for i in range(len(self.known))])
        groups = {
            kind: np.flatnonzero(kinds == kind) for kind in {kinds[i] for some in self.chosen for i in some} - {"None"}
        }
        return {kind: Alike(self.known, some) for kind, some in sorted(groups.items()) if len(some) > LEAST}

    def made(self, j: int) -> Spanned | None:
        """New shape j as a mixture; None where too few known shapes correspond.

        It begins where the map says that the likest known shape lies. A cloud, whose maps ask that it stands upright,
        begins where a turn and a shift lay a known shape on it, or the next one, and is bent from the best of these.
        """
        shape, like = self.strangers[j], self.chosen[j]
        if isinstance(shape, Mesh):
            corners, weights = self.maps.points(len(self.known) + j, like[0])
            return self._made(j, like[0], np.einsum("vc,vcx->vx", weights, shape.vertices[corners]), True)
        best = None
        for i in like:
            pose = rigid(self.known[i], shape, "forbid").best
            found = self._made(j, i, self.known[i].vertices @ pose.rotation + pose.shift, False)
            if found is not None and (best is None or found.off < best[0].off):
                best = found, i
            if best is not None and best[0].off <= CLEAR:
                return best[0]
        return None if best is None else self._made(j, best[1], best[0].points, True)

    def _made(self, j: int, i: int, places: np.ndarray, bend: bool) -> Spanned | None:
        """New shape j from where about known shape i lies on it; see `spanned`."""
        alike = self.alike.get(str(self.bases[i].connectivity))
        return (
            None if alike is None else spanned(alike, self.bases[i].mass, places, self.strangers[j], self.own[j], bend)
        )

    def __getstate__(self):
        _ = self.alike  # made once, here, and not by every worker
        return vars(self)


def mixtures(starts: Starts, described: Sequence, cache: Cache | None, workers: int | None) -> list[Spanned | None]:
    """Each new shape as a mixture of known ones, see `Starts.made`.

    Args:
        starts: with maps of meshes that are computed already.
        described: these maps in plain words, for the cache.
        cache: None keeps nothing.
        workers: see `in_parallel`.
    """
    if not starts.alike:
        return [None] * len(starts.chosen)
    keys: list[str | None] = [None] * len(starts.chosen)
    if cache is not None and starts.known.key is not None:
        shapes = [starts.strangers.shape_key(j) for j in range(len(keys))]
        how = [VERSION, starts.known.key, list(described)]
        keys = [
            None if shape is None else fingerprint(STAGE, how, shape, list(starts.chosen[j]), starts.own[j])
            for j, shape in enumerate(shapes)
        ]
    return list(in_parallel(_made, range(len(keys)), "mixtures", workers, starts, keys, cache))


def _made(j: int, starts: Starts, keys: Sequence[str | None], cache: Cache | None) -> Spanned | None:
    key = keys[j]
    if cache is None or key is None:
        return starts.made(j)
    kept = cache.get(STAGE, key, lambda: vars(starts.made(j) or _NONE))
    return Spanned(**kept) if len(kept["shapes"]) else None


_NONE = Spanned(np.empty(0, dtype=int), np.empty((0, 3)), np.array(np.inf), np.array(False))
