"""All steps of matching from the likeliest starts: several maps, of which `measures.chosen` takes one."""

import numpy as np

from lssd_learn.maps.matching.bending import Bent, Rough, bent, laid, roughly, told
from lssd_learn.maps.matching.features import Features, features
from lssd_learn.maps.matching.lattice import lattices
from lssd_learn.maps.matching.measures import Measures, measures, unlikeness
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.matching.spectral import samples_matched
from lssd_learn.maps.matching.starts import starts

TRIED, ALL = 4, 8  # starts at most, and where these leave doubts
WORSE = 1.8  # a start worse than the best by more than this factor is given up
HOPELESS = 4.0  # and one whose misfit is, after a net was bent
LOOKS = 3  # power of how unlike points look against what bending costs, in the misfit


def candidates(
    source: Prepared, target: Prepared, every: bool = False, tried: int = TRIED
) -> list[tuple[Bent, Measures]]:
    """The source bent onto the target from each of the likeliest starts, and what can be seen of these maps.

    Args:
        source, target: the two shapes.
        every: keep starts that are clearly worse than another, which are given up on the way.
        tried: starts at most.
    """
    looks, nets = features(source, target), lattices(source)
    likely = starts(source, target, looks)[:tried]
    likely = [start for start in likely if every or start.badness < WORSE * likely[0].badness]
    roughs = [laid(source, target, *samples_matched(source, target, start.C)) for start in likely]
    for level in range(len(nets)):
        roughs = [roughly(nets, level, target, rough) for rough in roughs]
        fits = np.array([_misfit(rough, source, target, looks) for rough in roughs])
        roughs = [rough for rough, fit in zip(roughs, fits, strict=True) if every or fit <= HOPELESS * fits.min()]
    roughs = [told(nets[-1], target, looks, rough) for rough in roughs]
    ways = [bent(source, target, looks, rough) for rough in roughs]
    return [(way, measures(source, target, looks, way)) for way in ways]


def _misfit(rough: Rough, source: Prepared, target: Prepared, looks: tuple[Features, Features]) -> float:
    """What tells a hopeless match: what it costs in bending, and how unlike matched points look."""
    there = unlikeness(looks, rough.there, target.samples).mean()
    back = unlikeness(looks, source.samples, rough.back).mean()
    return float(rough.energy * ((there + back) / 2) ** LOOKS)
