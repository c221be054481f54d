"""Maps are the same whichever of two shapes comes first in a collection: groups are listed one after the other."""

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.maps import AdjointMaps, AutoMaps, KernelMatchingMaps, RegistrationMaps, SplineMaps
from lssd_learn.maps.match import matched, on_source, on_target, ready


class Marked(ShapeList):
    """Shapes of which landmarks are known."""

    def __init__(self, shapes, landmarks):
        super().__init__(shapes)
        self.landmarks = landmarks


@pytest.mark.parametrize("method", [AutoMaps, RegistrationMaps, KernelMatchingMaps, SplineMaps, AdjointMaps])
def test_either_comes_first(bodies, method):
    shapes, bases = [bodies.source_shape, bodies.target_shape], [bodies.source, bodies.target]
    marks = [dict(enumerate(found.tolist())) for found in (bodies.source_landmarks, bodies.target_landmarks)]
    one, other = (method(bases[::way], Marked(shapes[::way], marks[::way])) for way in (1, -1))
    np.testing.assert_array_equal(one(0, 1), other(1, 0))
    np.testing.assert_array_equal(one(1, 0), other(0, 1))
    for kept, same in zip(one.points(0, 1), other.points(1, 0), strict=True):
        np.testing.assert_array_equal(kept, same)
    assert one.quality(0, 1) == other.quality(0, 1)
    assert one.unreached(0, 1) == other.unreached(1, 0)


def test_of_a_new_shape_and_a_known_one_it_is_the_known_one(bodies):
    class Asked(RegistrationMaps):
        def vertex_maps(self, i, j):
            asked.append((i, j))
            return super().vertex_maps(i, j)

    for way in (1, -1):
        asked = []
        shapes, bases = [bodies.source_shape, bodies.target_shape], [bodies.source, bodies.target]
        maps = Asked(bases[::way], ShapeList(shapes[::way]))
        maps.known = 1
        maps(1, 0)
        assert asked == [(0, 1)]


def test_what_is_bent_is_bent_back(bodies):
    """Neither shape's own form stays in the map; bent one way, it differs from the other by .001 of √area."""
    source, target = (
        ready(*both) for both in ((bodies.source_shape, bodies.source), (bodies.target_shape, bodies.target))
    )
    ways = on_source(source, target, matched(source, target)), on_target(target, source, matched(target, source))
    one, other = (np.einsum("vc,vcx->vx", weights, source.points[corners]) for corners, weights in ways)
    assert np.linalg.norm(one - other, axis=1).mean() < 2e-4
