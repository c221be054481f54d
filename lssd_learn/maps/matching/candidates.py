"""All steps of matching from the likeliest starts: several maps, of which `measures.chosen` takes one."""

from lssd_learn.maps.matching.bending import Bent, bent, laid, roughly
from lssd_learn.maps.matching.features import features
from lssd_learn.maps.matching.lattice import lattices
from lssd_learn.maps.matching.measures import Measures, measures
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.matching.spectral import samples_matched
from lssd_learn.maps.matching.starts import starts

TRIED = 4  # starts


def candidates(source: Prepared, target: Prepared) -> list[tuple[Bent, Measures]]:
    """The source bent onto the target from each of the likeliest starts, and what can be seen of these maps."""
    looks, nets, found = features(source, target), lattices(source), []
    for start in starts(source, target, looks)[:TRIED]:
        rough = laid(source, target, *samples_matched(source, target, start.C))
        for level in range(len(nets)):
            rough = roughly(nets, level, target, rough)
        way = bent(source, target, rough)
        found.append((way, measures(source, target, looks, way)))
    return found
