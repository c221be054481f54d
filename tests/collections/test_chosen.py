import numpy as np
import pytest

from lssd_learn.collections import Bodies
from lssd_learn.collections.chosen import Chosen
from lssd_learn.collections.generated.posed import Made, Posed
from lssd_learn.errors import InputError

SMALL = {"seed": 3, "topology": "notoes_collapse5pc"}


@pytest.fixture(scope="module")
def bodies():
    return Bodies(12, **SMALL)


def test_chosen_shapes_are_those_of_their_collections(bodies):
    posed = Posed(bodies, [(4, "sitting")])
    chosen = Chosen([(bodies, 5), (posed, 0)])
    assert chosen.names == ["body_0005", "body_0004:sitting"]
    assert chosen.up == "z"
    np.testing.assert_array_equal(chosen[0].vertices, bodies[5].vertices)
    np.testing.assert_array_equal(chosen[1].vertices, bodies.make(bodies.parameters[4], "sitting").vertices)
    assert [chosen.shape_key(i) for i in range(2)] == [bodies.shape_key(5), posed.shape_key(0)]
    assert chosen.key != Chosen([(bodies, 5)]).key
    assert Chosen([]).names == []


def test_a_body_in_its_own_pose_is_known_by_its_own_key(bodies):
    posed = Posed(bodies, [(3, "sitting"), (3, 0), (11, 3)])
    assert posed.names == ["body_0003:sitting", "body_0003:rest", "body_0011:sitting"]
    assert posed.shape_key(0) == bodies.shape_key(3)
    assert posed.shape_key(1) not in (bodies.shape_key(3), posed.shape_key(2))
    np.testing.assert_array_equal(posed[0].vertices, bodies[3].vertices)
    shaken = Bodies(12, **SMALL, jitter=5)
    assert Posed(shaken, [(3, "sitting")]).shape_key(0) != shaken.shape_key(3)


def test_a_body_of_any_parameters(bodies):
    made = Made(bodies, bodies.parameters[2], "bend", "truth")
    assert (len(made), made.names) == (1, ["truth"])
    np.testing.assert_array_equal(made[0].vertices, bodies.make(bodies.parameters[2], "bend").vertices)
    assert made.shape_key(0) != Made(bodies, bodies.parameters[2], "rest", "truth").shape_key(0)


def test_poses_that_are_none(bodies):
    for wrong in (lambda: Posed(bodies, [(0, "flying")]), lambda: Made(bodies, bodies.parameters[0], 8, "x")):
        with pytest.raises(InputError, match="pose: expected one of"):
            wrong()
