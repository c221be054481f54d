"""Maps by name, as a notebook asks for them: "auto", "registration", …"""

from collections.abc import Callable, Sequence

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.maps.auto import AutoMaps
from lssd_learn.maps.computed import AdjointMaps, KernelMatchingMaps, LandmarkMaps, RegistrationMaps, SplineMaps
from lssd_learn.maps.pairs import PairMaps, VertexMaps
from lssd_learn.shapes import Eigenbasis

Make = Callable[..., PairMaps]  # eigenbases, collection → PairMaps


def given_or_matched(bases: Sequence[Eigenbasis], collection: Collection) -> PairMaps:
    """ "auto": vertex correspondences where all shapes share their faces or maps are given, and else `AutoMaps`."""
    maps = VertexMaps(bases, collection)
    return maps if maps.is_identity or len(collection.vertex_maps) else AutoMaps(bases, collection)


given_or_matched.version = AutoMaps.version  # of what is computed, for the key of the cache

MAPS: dict[str, Make] = {
    "auto": given_or_matched,
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
