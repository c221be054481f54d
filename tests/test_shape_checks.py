"""Signatures hold while the tests run: an array of another shape or kind is refused, by the import hook alone."""

import tomllib
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float, TypeCheckError
from shape_checks import ROOMS, names_array

import lssd_learn
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.edges import edge_lengths

VERTICES, EDGES = np.zeros((3, 3)), np.array([[0, 1], [1, 2]])


@pytest.mark.parametrize(
    ("vertices", "edges"), [(np.zeros((3, 4)), EDGES), (VERTICES, EDGES[None]), (VERTICES, EDGES.astype(float))]
)
def test_an_array_of_another_shape_or_kind_is_refused(vertices, edges):
    edge_lengths(VERTICES, EDGES)
    with pytest.raises(TypeCheckError, match="edge_lengths"):
        edge_lengths(vertices, edges)


def test_it_is_the_hook_that_refuses():
    assert edge_lengths.__wrapped__(np.zeros((3, 4)), EDGES).shape == (2,)


def test_fields_that_do_not_fit_each_other_are_refused():
    Eigenbasis(np.zeros(2), np.zeros((3, 2)), np.ones(3), None)
    with pytest.raises(TypeCheckError, match="Eigenbasis"):
        Eigenbasis(np.zeros(2), np.zeros((3, 2)), np.ones(4), None)


@pytest.mark.parametrize("room", ROOMS)
def test_every_room_is_hooked(room):
    assert type(import_module(f"lssd_learn.{room}").__loader__).__module__.startswith("jaxtyping")


def test_annotations_that_name_an_array_are_told_from_others():
    array = Float[np.ndarray, "n 3"]
    assert names_array(array)
    assert names_array(tuple[array, int] | None)
    assert names_array(dict[str, array])
    assert not names_array(int | None)
    assert not names_array(list[np.ndarray])


def test_the_type_checker_looks_at_the_whole_package():
    told = tomllib.loads((Path(lssd_learn.__file__).parents[1] / "pyproject.toml").read_text())["tool"]["pyright"]
    assert told["include"] == ["lssd_learn"]
    assert not {"exclude", "ignore", "strict"} & set(told)
    assert not any(name.startswith("report") for name in told)
    assert (Path(lssd_learn.__file__).parent / "py.typed").is_file()


def test_no_file_is_left_out_by_a_comment():
    for file in Path(lssd_learn.__file__).parent.rglob("*.py"):
        assert "# type: ignore" not in file.read_text(), file
        assert "# pyright: basic" not in file.read_text(), file
