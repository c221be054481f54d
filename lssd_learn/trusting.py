"""Networks without the maps that are not to be trusted, and what is known of the ones they have."""

import logging
from collections.abc import Sequence
from typing import cast

import numpy as np
from jaxtyping import Bool, Int

from lssd_learn.errors import some_of
from lssd_learn.latent import MapNetwork
from lssd_learn.latent.graphs.lacking import lacking
from lssd_learn.latent.graphs.topology import components
from lssd_learn.latent.graphs.trusted import trusted
from lssd_learn.maps import PairMaps

log = logging.getLogger(__name__)


def trusted_network(network: MapNetwork, maps: PairMaps, names: Sequence[str]) -> MapNetwork:
    """The network without the edges whose maps are below the quality that `maps` asks for.

    It stays connected: where shapes hang on nothing better, the best of these maps stays, and they are named. So are
    shapes that seem to lack a part, and those that most maps fail at though some is good: they may be of another kind.

    Args:
        network: connected, its maps computed.
        maps: of its shapes.
        names: of its shapes.
    """
    edges = network.pairs()
    odd = lacking(network.n, edges, [maps.unreached(i, j) for i, j in edges.tolist()])
    if odd:
        log.warning(
            "maps: %d of %d shapes seem to lack a part that the others have, or to be of another kind: %s",
            len(odd), network.n, some_of([names[i] for i in odd]),
        )  # fmt: skip
    qualities = np.array([np.nan if q is None else q for q in (maps.quality(i, j) for i, j in edges.tolist())])
    kept, bridges = trusted(network.n, edges, qualities, maps.level)
    if kept.all() and not len(bridges):
        return network
    lost: list[int] = []
    if len(bridges):
        sure = kept.copy()
        sure[bridges] = False
        parts = components(network.n, edges[sure])
        lost = [int(i) for part in parts[1:] for i in part]
        log.warning(
            "maps: no map to be trusted (quality %g or more) joins %d of %d shapes to the others: %s; what their "
            "operators tell beside those of the others is not to be trusted either",
            maps.level, len(lost), network.n, some_of([names[i] for i in lost]),
        )  # fmt: skip
    among = ~np.isin(edges, lost + odd).any(axis=1)
    if few := _mostly(edges[among], qualities[among] < maps.level, network.n):
        log.warning(
            "maps: of %d of %d shapes most maps to the others are not to be trusted: %s",
            len(few), network.n, some_of([names[i] for i in few]),
        )  # fmt: skip
    if not kept.all():
        log.info("maps: %d of %d are left out of the network", int((~kept).sum()), len(kept))
    return network.only(kept)


def _mostly(edges: Int[np.ndarray, "m 2"], bad: Bool[np.ndarray, " m"], n: int) -> list[int]:
    """The shapes of n of whose edges more than half are bad."""
    degrees, of_bad = (np.bincount(some.ravel(), minlength=n) for some in (edges, edges[bad]))
    return np.flatnonzero(2 * of_bad > degrees).tolist()


def quality_rows(network: MapNetwork, maps: PairMaps, names: Sequence[str]) -> list[dict[str, object]]:
    """A row an edge, the worst first: its shapes, and the quality of the map between them, where that is known.

    Then the shares of the area of both that the other does not reach, see `PairMaps.unreached`.
    """
    rows: list[dict[str, object]] = []
    for i, j in network.pairs().tolist():
        if (quality := maps.quality(i, j)) is not None:
            row: dict[str, object] = {"source": names[i], "target": names[j], "quality": quality}
            row["trusted"] = int(quality >= maps.level)
            row["source_unreached"], row["target_unreached"] = maps.unreached(i, j) or (None, None)
            rows.append(row)
    return sorted(rows, key=lambda row: cast(float, row["quality"]))
