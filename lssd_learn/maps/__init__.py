"""One functional map: how functions on one shape become functions on another."""

from lssd_learn.maps.adjoint import adjoint
from lssd_learn.maps.auto import AutoMaps
from lssd_learn.maps.computed import ComputedMaps, KernelMatchingMaps, RegistrationMaps
from lssd_learn.maps.conversion import to_vertices
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.kernel_matching import kernel_matching
from lssd_learn.maps.landmarks import landmarks
from lssd_learn.maps.marked import AdjointMaps, LandmarkMaps, SplineMaps
from lssd_learn.maps.match import Match, match
from lssd_learn.maps.named import MAPS, named_maps
from lssd_learn.maps.pairs import PairMaps, VertexMaps
from lssd_learn.maps.quality import (
    area_under_curve,
    coverage,
    cycle_error,
    euclidean_errors,
    flipped,
    geodesic_errors,
    round_trip_errors,
    turned_over,
    unreached,
)
from lssd_learn.maps.registration import registration
from lssd_learn.maps.zoomout import zoomout

__all__ = [
    "MAPS",
    "AdjointMaps",
    "AutoMaps",
    "ComputedMaps",
    "KernelMatchingMaps",
    "LandmarkMaps",
    "Match",
    "PairMaps",
    "RegistrationMaps",
    "SplineMaps",
    "VertexMaps",
    "adjoint",
    "area_under_curve",
    "coverage",
    "cycle_error",
    "euclidean_errors",
    "flipped",
    "from_correspondence",
    "geodesic_errors",
    "kernel_matching",
    "landmarks",
    "match",
    "named_maps",
    "registration",
    "round_trip_errors",
    "to_vertices",
    "turned_over",
    "unreached",
    "zoomout",
]
