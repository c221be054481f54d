"""One functional map: how functions on one shape become functions on another."""

from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.pairs import VertexMaps

__all__ = ["VertexMaps", "from_correspondence"]
