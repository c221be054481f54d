"""Where the map of a pair comes from: identity, a given one, or one between the same two connectivities."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lssd_learn.collections import Folder, ShapeList
from lssd_learn.errors import InputError
from lssd_learn.maps import LandmarkMaps, VertexMaps, from_correspondence
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import eigenbasis, save


@pytest.fixture(scope="module")
def bases(deformed_spheres):
    """Shapes 0 and 1 of 42 vertices, 2 and 3 of 162."""
    return [eigenbasis(mesh, 10) for subdivisions in (1, 2) for mesh in deformed_spheres(2, subdivisions)]


@pytest.fixture(scope="module")
def vertices():
    """For each vertex of a 162-vertex shape one of a 42-vertex shape."""
    return np.random.default_rng(0).integers(0, 42, 162)


def known(given, names):
    """A collection of which only vertex maps and names are asked for."""
    collection = ShapeList([])
    collection.vertex_maps, collection.names = given, list(names)
    return collection


def test_one_connectivity_needs_no_maps(bases):
    maps = VertexMaps(bases[:2], known({}, "ab"))
    assert maps.is_identity
    np.testing.assert_array_equal(maps(0, 1), from_correspondence(bases[0], bases[1]))
    np.testing.assert_array_equal(maps(1, 0), from_correspondence(bases[1], bases[0]))
    corners, weights = maps.points(0, 1)
    np.testing.assert_array_equal(corners[:, 0], np.arange(42))
    np.testing.assert_array_equal(weights.sum(axis=1), 1)


def test_two_connectivities_or_clouds_do(bases):
    assert not VertexMaps(bases, known({}, "abcd")).is_identity
    clouds = [replace(basis, connectivity=None) for basis in bases[:2]]
    assert not VertexMaps(clouds, known({}, "ab")).is_identity
    with pytest.raises(InputError, match="maps: a and b are not in vertex correspondence"):
        VertexMaps(clouds, known({}, "ab"))(0, 1)
    given = np.arange(42)[::-1]
    np.testing.assert_array_equal(
        VertexMaps(clouds, known({(0, 1): given}, "ab"))(0, 1), from_correspondence(*clouds, given)
    )


def test_a_given_map_serves_all_pairs_of_its_connectivities(bases, vertices):
    maps = VertexMaps(bases, known({(0, 2): vertices}, "abcd"))
    for i in (0, 1):
        for j in (2, 3):
            np.testing.assert_array_equal(maps(i, j), from_correspondence(bases[i], bases[j], vertices))
    np.testing.assert_array_equal(maps(3, 2), from_correspondence(bases[3], bases[2]))


def test_a_map_given_for_a_pair_goes_before_all_else(bases, vertices):
    other = np.random.default_rng(1).integers(0, 42, 162)
    shuffle = np.random.default_rng(2).permutation(42)
    maps = VertexMaps(bases, known({(0, 2): vertices, (1, 3): other, (0, 1): shuffle}, "abcd"))
    np.testing.assert_array_equal(maps(0, 2), from_correspondence(bases[0], bases[2], vertices))
    np.testing.assert_array_equal(maps(1, 3), from_correspondence(bases[1], bases[3], other))
    np.testing.assert_array_equal(maps(0, 1), from_correspondence(bases[0], bases[1], shuffle))


def test_a_missing_map_is_named(bases, vertices):
    maps = VertexMaps(bases, known({(0, 2): vertices}, ["cat", "kitten", "lion", "cub"]))
    with pytest.raises(
        InputError, match="maps: cub and kitten are not in vertex correspondence; expected maps/cub__kitten.txt"
    ):
        maps(3, 1)


@pytest.fixture
def mixed(tmp_path, deformed_spheres):
    """A folder: a, b of 42 vertices, c of 162."""
    for name, mesh in zip("abc", [*deformed_spheres(2, 1), *deformed_spheres(1, 2)], strict=True):
        save(mesh, tmp_path / f"{name}.off")
    return tmp_path


def test_what_is_lacking_is_told_before_the_work(mixed, deformed_spheres):
    for every_pair in (True, False):
        with pytest.raises(InputError, match="^maps: a and c are not in .*expected maps/a__c.txt, .*, or maps=k"):
            VertexMaps.check(Folder(mixed), every_pair)
    (mixed / "landmarks.csv").write_text("name,landmark,vertex\na,x,1\n")
    with pytest.raises(InputError, match=r"maps=landmarks or spline \(landmarks.csv is there\), maps=kernel"):
        VertexMaps.check(Folder(mixed), True)
    with pytest.raises(InputError, match="expected landmarks on every shape, b has none"):
        LandmarkMaps.check(Folder(mixed), True)
    (mixed / "landmarks.csv").unlink()
    (mixed / "maps").mkdir()
    nearest = cKDTree(deformed_spheres(2, 1)[1].vertices).query(deformed_spheres(1, 2)[0].vertices)[1]
    (mixed / "maps" / "b__c.txt").write_text("\n".join(map(str, nearest)))
    for every_pair in (True, False):
        VertexMaps.check(Folder(mixed), every_pair)


def test_shapes_of_the_same_faces_lack_nothing(small_mesh_folder):
    VertexMaps.check(Folder(small_mesh_folder), True)
    LandmarkMaps.check(Folder(small_mesh_folder), True)
    with pytest.raises(InputError, match="expected landmarks on every shape"):
        LandmarkMaps.check(Folder(small_mesh_folder), True, correspondence="none")
    VertexMaps.check(ShapeList([]), True)  # nothing is known of it


def test_a_pipeline_looks_before_it_computes(mixed, cache):
    with pytest.raises(InputError, match="no files maps/a__c.txt"):
        Pipeline(Folder(mixed), k=8, size=6, keep=4, cache=cache).map_network()
    assert not (cache.root / "eigenbasis").exists()
