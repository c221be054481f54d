"""What a folder warns of is said in every run, once."""

import logging

import numpy as np
import pytest

from lssd_learn.collections import Folder, Subset, eigenbases
from lssd_learn.collections.checked import ensure_checked
from lssd_learn.shapes import Mesh, load, save


@pytest.fixture
def odd(small_mesh_folder):
    """A folder one of whose shapes is a thousand times larger."""
    file = small_mesh_folder / "shape_1.ply"
    mesh = load(file)
    save(Mesh(1000 * mesh.vertices, mesh.faces), file)
    return small_mesh_folder


def said(caplog):
    return [message for message in caplog.messages if "times larger" in message]


def test_warnings_are_said_again_in_the_next_run_and_once_in_each(odd, cache, caplog):
    caplog.set_level(logging.INFO)
    for _ in range(2):
        shapes = Folder(odd)
        eigenbases(shapes, 6, cache=cache)
        ensure_checked(shapes, cache)
        ensure_checked(shapes, cache)
        assert len(said(caplog)) == 1
        caplog.clear()
    ensure_checked(Subset(Folder(odd), [0, 1, 3]), cache)
    assert len(said(caplog)) == 1


def test_all_that_was_said_is_there_in_the_next_run(odd, cache):
    first = ensure_checked(Folder(odd), cache)
    assert any("times larger" in message for message in first)
    assert ensure_checked(Folder(odd), cache) == first
    assert ensure_checked(Subset(Folder(odd), [0, 1, 3]), None) == first


def test_faces_are_known_after_the_check(odd):
    shapes = Folder(odd)
    kinds = shapes.connectivities
    assert kinds == [shape.connectivity for shape in shapes]
    assert Subset(shapes, [2, 1]).connectivities == [kinds[2], kinds[1]]
    assert np.unique(kinds).size == 1
