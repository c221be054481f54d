"""Eigenbases, clouds and previews of a collection: the same from the cache, and from any number of processes."""

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from lssd_learn.cache import Cache
from lssd_learn.collections import clouds, eigenbases, previews
from lssd_learn.collections.base import ShapeList
from lssd_learn.collections.clouds import clouds_key, origin_of
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis


class Untouched(ShapeList):
    """A collection whose shapes must not be asked for."""

    def __getitem__(self, i):
        raise AssertionError(f"shape {i} was asked for")


def test_eigenbases_from_the_cache_are_those_of_the_shapes(spheres, meshes, cache):
    stored = eigenbases(spheres(), 16, cache=cache)
    for basis, mesh in zip(stored, meshes, strict=True):
        with threadpool_limits(1):  # as in a worker: the same bits at the same thread count
            exact = eigenbasis(mesh, 16)
        np.testing.assert_array_equal(basis.evals, exact.evals)
        np.testing.assert_array_equal(basis.evecs, exact.evecs.astype(np.float32))
        np.testing.assert_array_equal(basis.mass, exact.mass)
        assert basis.connectivity == mesh.connectivity


@pytest.fixture(scope="module")
def one_and_two_workers(meshes, tmp_path_factory):
    made = []
    for workers in (1, 2):
        shapes = ShapeList(meshes)
        shapes.key = "spheres"
        cache = Cache(tmp_path_factory.mktemp(f"workers{workers}"))
        made.append((eigenbases(shapes, 16, cache=cache, workers=workers), clouds(shapes, 40, 5, cache, workers)))
    return made


def test_eigenbases_do_not_depend_on_the_number_of_workers(one_and_two_workers):
    (one, _), (two, _) = one_and_two_workers
    for a, b in zip(one, two, strict=True):
        for name in ("evals", "evecs", "mass"):
            assert getattr(a, name).tobytes() == getattr(b, name).tobytes()
        assert a.connectivity == b.connectivity


def test_clouds_do_not_depend_on_the_number_of_workers(one_and_two_workers):
    (_, one), (_, two) = one_and_two_workers
    assert one.tobytes() == two.tobytes()


def test_clouds_are_a_function_of_the_seed(spheres, meshes, cache):
    first = clouds(spheres(), 40, 5, cache)
    assert (first.shape, first.dtype) == ((6, 40, 3), np.float32)
    assert first.tobytes() == clouds(meshes, 40, 5, None).tobytes()
    assert not np.array_equal(first, clouds(meshes, 40, 6, None))
    assert first[3].tobytes() == clouds(meshes[:4], 40, 5, None)[3].tobytes()  # of nothing but seed and place
    assert len({row.tobytes() for row in clouds([meshes[0]] * 3, 40, 5, None)}) == 3


def test_previews_come_from_the_cache(spheres, meshes, cache):
    first = previews(spheres(), 2, cache)
    again = previews(spheres(Untouched), 2, cache)
    for a, b, mesh in zip(first, again, meshes, strict=False):
        np.testing.assert_array_equal(a.vertices, mesh.vertices)
        np.testing.assert_array_equal(b.vertices, mesh.vertices)
        assert b.connectivity == mesh.connectivity
    points = ShapeList([PointCloud(mesh.vertices) for mesh in meshes])
    points.key = "points"
    assert isinstance(previews(points, 1, cache)[0], PointCloud)


FAR = np.array([3.9e6, 1.1e6, 4.9e6])


@pytest.fixture
def far(meshes):
    """Where float32 has a few points for each."""
    return [Mesh(mesh.vertices + FAR, mesh.faces) for mesh in meshes]


def test_clouds_far_from_the_origin_are_refused(far):
    """A network would learn from a few points."""
    with pytest.raises(InputError, match=r"4.9e\+06 from the origin and .* across, where float32"):
        clouds(far, 40, cache=None, workers=1)


def test_clouds_far_from_zero_lie_about_an_origin_of_their_own(meshes, far, cache):
    origin = origin_of(far)
    assert np.abs(origin - FAR).max() < 2
    near, moved = clouds(meshes, 40, cache=None), clouds(far, 40, cache=None, workers=1, origin=origin)
    np.testing.assert_allclose(moved + origin - FAR, near, atol=1e-6)
    assert not origin_of(meshes).any()
    with pytest.raises(InputError, match=r"from the origin of the clouds \(7800000, 2200000, 9800000\)"):
        clouds(meshes, 40, cache=None, workers=1, origin=2 * FAR)
    assert len({clouds_key(ShapeList(meshes), 40, 0, where) for where in (None, origin, 2 * FAR)}) == 3
    assert clouds_key(ShapeList(meshes), 40, 0, np.zeros(3)) == clouds_key(ShapeList(meshes), 40, 0)
