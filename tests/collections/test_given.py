"""Several shapes in every form a person may have them in, and what the cache knows them by."""

import numpy as np
import pytest

from lssd_learn.collections import AtHand, Folder, Subset, as_collection, eigenbases
from lssd_learn.errors import InputError
from lssd_learn.shapes import save


def test_a_folder_by_its_path(small_mesh_folder):
    for path in (small_mesh_folder, str(small_mesh_folder)):
        assert isinstance(as_collection(path), Folder)


def test_files_are_read_when_asked_for_and_have_their_names(meshes, tmp_path):
    paths = [tmp_path / "b.off", tmp_path / "a.off"]
    for mesh, path in zip(meshes, paths, strict=False):
        save(mesh, path)
    collection = as_collection([*paths, meshes[2]])
    assert collection.names == ["b", "a", "2"]
    assert as_collection([paths[0], paths[0]]).names == ["0", "1"]
    np.testing.assert_array_equal(collection[1].vertices, meshes[1].vertices)
    paths[1].unlink()
    with pytest.raises(InputError, match=r"a.off: no such file"):
        collection[1]


def test_the_same_shape_is_found_again_in_another_list(meshes, cache):
    eigenbases(meshes, 9, cache=cache)
    made = {path.stem for path in (cache.root / "eigenbasis").glob("*/*.arrays")}
    again = eigenbases([meshes[4], meshes[1]], 9, cache=cache)
    assert {path.stem for path in (cache.root / "eigenbasis").glob("*/*.arrays")} == made
    np.testing.assert_array_equal(again[1].evals, eigenbases(meshes, 9, cache=cache)[1].evals)
    assert len(eigenbases(Subset(as_collection(meshes), [3]), 9, cache=cache)) == 1
    assert {path.stem for path in (cache.root / "eigenbasis").glob("*/*.arrays")} == made


def test_the_key_is_of_all_shapes_in_their_order(meshes):
    keys = {AtHand(some).key for some in (meshes, meshes[::-1], meshes[:5])}
    assert len(keys) == 3
    assert AtHand(list(meshes)).key in keys


def test_one_shape_or_none_is_told(meshes, tmp_path):
    save(meshes[0], tmp_path / "a.off")
    mesh = meshes[0]
    for given in (mesh, (mesh.vertices, mesh.faces), mesh.vertices):
        with pytest.raises(InputError, match=r"expected several in a sequence, got one .*: write \[shape\]"):
            as_collection(given)
    with pytest.raises(InputError, match=r"got one file: write \['.*a.off'\]"):
        as_collection(tmp_path / "a.off")
    with pytest.raises(InputError, match="expected a collection, a folder or a sequence of shapes, got int"):
        as_collection(3)
    with pytest.raises(InputError, match=r"shapes\[1\]: expected a Mesh"):
        as_collection([mesh, None])
