import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.division.protocols import Division, divide, fitted
from lssd_learn.errors import InputError
from lssd_learn.learning import split

FRACTIONS = {"train": 0.75, "test": 0.15, "validation": 0.10}


@pytest.fixture
def shapes():
    """A function: groups → 40 shapes that have them."""

    def make(**groups):
        collection = ShapeList([None] * 40)
        collection.groups = groups
        return collection

    return make


def data(protocol="transductive", held_out=None):
    return Division(FRACTIONS, protocol, held_out)


def same(a, b):
    return all((x == y).all() for (_, x), (_, y) in zip(a.items(), b.items(), strict=True))


def test_the_protocol_decides_what_the_latent_space_is_fitted_to(shapes):
    transductive, inductive = data(), data("inductive")
    assert fitted(shapes(), 3, transductive) is None
    np.testing.assert_array_equal(fitted(shapes(), 3, inductive), split(40, 3).train)
    assert same(divide(shapes(), 3, inductive), divide(shapes(), 3, transductive))


def test_a_number_of_shapes_makes_the_latent_space(shapes):
    found = fitted(shapes(), 3, data(), 10)
    assert len(set(found)) == 10
    assert (np.diff(found) > 0).all()
    assert set(found) <= set(range(40))
    np.testing.assert_array_equal(found, fitted(shapes(), 3, data(), 10))
    assert not np.array_equal(found, fitted(shapes(), 4, data(), 10))
    assert set(fitted(shapes(), 3, data("inductive"), 10)) <= set(split(40, 3).train)
    assert fitted(shapes(), 3, data(), 40) is None
    for number in (1, 41, 2.5):
        with pytest.raises(InputError, match=f"latent.fitted={number}: expected a whole number, 2 to 40"):
            fitted(shapes(), 3, data(), number)


@pytest.mark.parametrize("names", [("pose",), ("sex", "pose"), ("kind",)])
def test_a_pose_is_held_out_whole(shapes, names):
    labels = np.arange(40) % 5
    collection = shapes(**dict.fromkeys(names, labels))
    parts = divide(collection, 1, data("held_out_pose", 2))
    np.testing.assert_array_equal(parts.test, np.flatnonzero(labels == 2))
    assert len(parts.validation) == round(32 * 0.10 / 0.85)
    assert len(parts.train) + len(parts.validation) == 32
    assert not np.isin(parts.train, parts.validation).any()
    np.testing.assert_array_equal(fitted(collection, 1, data("held_out_pose", "2")), parts.train)


@pytest.mark.parametrize(
    ("groups", "options", "message"),
    [
        ({}, data("loose"), "data.protocol=loose: expected one of transductive, inductive, held_out_pose"),
        ({}, data("held_out_pose"), "data.protocol=held_out_pose: expected shapes with groups"),
        ({"pose": ["rest", "bend"] * 20}, data("held_out_pose"), "data.held_out=None: expected one of rest, bend"),
        ({"pose": ["rest", "bend"] * 20}, data("held_out_pose", "T"), "data.held_out=T: expected one of rest, bend"),
        ({"a": ["x"] * 40, "b": ["x"] * 40}, data("held_out_pose", "x"), "held_out_pose: expected one of a, b"),
        ({"pose": ["rest"] * 40}, data("held_out_pose", "rest"), "40 shapes are too few"),
    ],
)
def test_errors(shapes, groups, options, message):
    with pytest.raises(InputError, match=message):
        divide(shapes(**groups), 0, options)


@pytest.mark.parametrize("protocol", ["transductive", "inductive"])
def test_all_shapes_of_a_person_stand_on_one_side(shapes, protocol):
    people = np.array([f"p{i // 4}" for i in range(40)], dtype=object)
    people[[0, 5]] = None, ""  # these stand alone
    collection, by = shapes(person=people), Division(FRACTIONS, protocol, by="person")
    for seed in range(20):
        parts = dict(divide(collection, seed, by).items())
        sides = [set(people[positions]) - {None, ""} for positions in parts.values()]
        assert sum(map(len, sides)) == 10
        if protocol == "inductive":
            np.testing.assert_array_equal(fitted(collection, seed, by), parts["train"])
    one = divide(collection, 0, Division(FRACTIONS, protocol, "p3", "person"))
    np.testing.assert_array_equal(one.test, np.flatnonzero(people == "p3"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (Division(FRACTIONS, by="man"), "data.by=man: expected one of person"),
        (Division(FRACTIONS, "held_out_pose", "b", "person"), "data.by=person: expected data.protocol=transductive or"),
        (Division(FRACTIONS, held_out="c", by="person"), "data.held_out=c: expected a label of person: a, b"),
        (Division(FRACTIONS, by="person"), "2 blocks are too few"),
    ],
)
def test_what_cannot_be_divided_by(shapes, options, message):
    with pytest.raises(InputError, match=message):
        divide(shapes(person=["a", "b"] * 20), 0, options)
