"""Maps of a folder: which ones are off everywhere."""

import shutil

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lssd_learn.collections import Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, save


@pytest.fixture
def permuted(folder, lumps):
    """s1 with its vertices in another order; a function writes a map from s0 to it. Gives the right map too."""
    mesh = lumps(5)[1]
    order = np.random.default_rng(0).permutation(len(mesh.vertices))
    place = np.argsort(order)
    save(Mesh(mesh.vertices[order], place[mesh.faces]), folder / "s1.off")
    (folder / "maps").mkdir()

    def write(vertices):
        (folder / "maps" / "s0__s1.txt").write_text("\n".join(map(str, vertices)))
        return Folder(folder)

    return order, write


def test_a_right_map_is_silent(permuted):
    order, write = permuted
    shapes = write(order)
    assert shapes.check() == []
    np.testing.assert_array_equal(shapes.vertex_maps[0, 1], order)


@pytest.mark.parametrize("top", [True, False])
def test_one_that_counts_from_one_is_named(permuted, top):
    order, write = permuted
    vertices = order + 1 if top else np.where(order == 161, 5, order + 1)
    with pytest.raises(InputError, match="counts from 1, take 1 off" if top else "counted from 1 the map is smooth"):
        write(vertices).check()


def test_a_random_one_is_refused(permuted):
    order, write = permuted
    with pytest.raises(InputError, match="s0__s1.txt: expected a map that takes neighbours to neighbours"):
        write(np.random.default_rng(1).permutation(order)).check()
    with pytest.raises(InputError, match="it seems to be the map the other way round"):
        write(np.argsort(order)).check()


def test_a_rough_one_is_a_warning(permuted):
    order, write = permuted
    vertices = order.copy()
    some = np.random.default_rng(0).choice(162, 40, replace=False)
    vertices[some] = vertices[np.roll(some, 1)]
    (warning,) = write(vertices).check()
    assert warning.startswith("s0__s1.txt: neighbours are mapped far apart")


def test_coarse_to_fine_and_fine_to_coarse_are_silent(folder, lumps):
    fine, coarse = lumps(2, 3)[1], lumps(1, 1)[0]
    save(fine, folder / "s1.off")
    save(coarse, folder / "s0.off")
    (folder / "maps").mkdir()
    for name, source, target in (("s0__s1", coarse, fine), ("s1__s0", fine, coarse)):
        nearest = cKDTree(source.vertices).query(target.vertices)[1]
        (folder / "maps" / f"{name}.txt").write_text("\n".join(map(str, nearest)))
    assert Folder(folder).check() == []


def test_names_in_one_piece_or_two_with_their_accents_and_capitals(folder):
    shutil.move(folder / "s0.off", folder / "Scha\u0308del.off")
    (folder / "MAPS").mkdir()
    (folder / "MAPS" / "Sch\u00e4del__s1.TXT").write_text("\n".join(map(str, range(162))))
    shapes = Folder(folder)
    assert shapes.names[0] == "Sch\u00e4del"
    assert set(shapes.vertex_maps) == {(0, 1)}
    (folder / "MAPS" / "Scha\u0308del__s1.txt").write_text("0")
    with pytest.raises(InputError, match="expected one map a pair"):
        Folder(folder)
