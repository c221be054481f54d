"""Whether the shapes of a collection have what the chosen maps need: asked before the eigenbases are computed."""

from collections.abc import Callable
from functools import partial
from typing import cast

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.maps.marked import LandmarkMaps, SplineMaps
from lssd_learn.maps.pairs import PairMaps, VertexMaps

FEW = 2  # shapes of a generated collection that are looked at: they are all of one kind


def ensure_mappable(maps: Callable[..., PairMaps], collection: Collection) -> None:
    """Refuse shapes that the maps cannot map, as far as that shows without eigenbases.

    Args:
        maps: of the pipeline: a class of maps or a partial of one.
        collection: n shapes; those of files are all looked at.

    Raises:
        InputError: shapes of different faces without maps between them, or without landmarks that they share; names
            the choices that would do.
    """
    kind, options = (maps.func, maps.keywords) if isinstance(maps, partial) else (maps, {})
    if kind not in (VertexMaps, LandmarkMaps, SplineMaps) or (kind is VertexMaps and len(collection.vertex_maps)):
        return
    other = None if options.get("correspondence") == "none" else _unlike_the_first(collection)
    if other is None and options.get("correspondence") != "none":
        return  # no maps are needed
    if kind is not VertexMaps:
        common_landmarks(collection, options.get("landmarks"))
        return
    a, b = collection.names[0], collection.names[cast(int, other)]  # vertex maps have no choice
    choices = [
        "maps=auto (for meshes, however they lie)",
        "maps=registration or maps=kernel_matching (for shapes that stand alike)",
    ]
    if len(collection.landmarks):
        choices.insert(0, "maps=landmarks or maps=spline (landmarks are there)")
    raise InputError(
        f"maps=correspondence: {a} and {b} are not in vertex correspondence: their faces are not the same, and there "
        f"are no files maps/{a}__{b}.txt; what would do: {', or '.join(choices)}"
    )


def _unlike_the_first(collection: Collection) -> int | None:
    """The first shape that has not the connectivity of shape 0; a cloud has none. None where all have it."""
    first = collection[0].connectivity
    looked_at = range(1, len(collection) if hasattr(collection, "files") else min(FEW, len(collection)))
    return next((i for i in looked_at if first is None or collection[i].connectivity != first), None)
