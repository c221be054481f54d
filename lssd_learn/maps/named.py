"""Maps by name, as a notebook asks for them: "auto", "registration", …"""

import logging
from collections.abc import Callable, Sequence

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.maps.computed import AdjointMaps, KernelMatchingMaps, LandmarkMaps, RegistrationMaps, SplineMaps
from lssd_learn.maps.pairs import PairMaps, VertexMaps
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)

Make = Callable[..., PairMaps]  # eigenbases, collection → PairMaps


def given_or_registered(bases: Sequence[Eigenbasis], collection: Collection) -> PairMaps:
    """ "auto": vertex correspondences where all shapes share their faces or maps are given, and else registration.

    That takes shapes to stand upright and to face one way, which nothing can check: a warning says so.
    """
    maps = VertexMaps(bases, collection)
    if maps.is_identity or len(collection.vertex_maps):
        return maps
    log.warning(
        "the shapes do not share their vertices, so maps between them are computed by registration: they are taken to "
        'stand upright and to face one way (maps="registration" says so, or name others)'
    )
    return RegistrationMaps(bases, collection)


given_or_registered.version = RegistrationMaps.version  # of what is computed, for the key of the cache

MAPS: dict[str, Make] = {
    "auto": given_or_registered,
    "correspondence": VertexMaps,
    "landmarks": LandmarkMaps,
    "adjoint": AdjointMaps,
    "kernel_matching": KernelMatchingMaps,
    "registration": RegistrationMaps,
    "spline": SplineMaps,
}


def named_maps(maps: str | Make) -> Make:
    """What a name of `MAPS` stands for; a class of maps, or a partial of one, comes back as it is.

    Raises:
        InputError: another name.
    """
    if callable(maps):
        return maps
    if maps not in MAPS:
        raise InputError(f"maps={maps!r}: expected one of {', '.join(MAPS)}, or a class of maps")
    return MAPS[maps]
