"""Maps by name, as a notebook asks for them: "auto", "registration", …"""

from collections.abc import Callable

from lssd_learn.errors import InputError
from lssd_learn.maps.auto import AutoMaps
from lssd_learn.maps.computed import KernelMatchingMaps, RegistrationMaps
from lssd_learn.maps.marked import AdjointMaps, LandmarkMaps, SplineMaps
from lssd_learn.maps.pairs import PairMaps, VertexMaps

Make = Callable[..., PairMaps]  # eigenbases, collection → PairMaps


MAPS: dict[str, Make] = {
    "auto": AutoMaps,
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
