import numpy as np
import pytest

from lssd_learn.collections import Bodies, Grown
from lssd_learn.collections.generated.body.growth import PLACES, weights
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"


@pytest.mark.parametrize("place", PLACES)
def test_a_place_grows_by_its_part_and_nothing_else_moves(place):
    bodies, inner = Bodies(1, topology=SMALL), weights(body_model(SMALL), place) > 0.5
    plain, grown = bodies.make({}), bodies.make({}, "rest", (place, 0.1))
    assert grown.vertex_areas[inner].sum() == pytest.approx(1.1 * plain.vertex_areas[inner].sum(), rel=1e-4)
    away = weights(body_model(SMALL), place) < 1e-9
    np.testing.assert_allclose(grown.vertices[away], plain.vertices[away], atol=1e-7)
    assert plain.vertex_areas[inner].sum() < 0.08 * plain.area


def test_the_pose_carries_along_what_has_grown():
    """An upper arm turns by 100°: the hand grows by the same vectors, turned."""
    bodies = Bodies(1, topology=SMALL)
    rest, posed = ([bodies.make({}, pose, growth).vertices for growth in (None, ("hand", 0.1))] for pose in (0, 7))
    moved = [np.linalg.norm(grown - plain, axis=1) for plain, grown in (rest, posed)]
    np.testing.assert_allclose(moved[0], moved[1], atol=1e-6)
    assert moved[0].max() > 0.002


def test_the_same_people_without_and_with_their_own_growth():
    bodies = Grown("neck", 0.05, n=9, dose=True, topology=SMALL)
    assert len(bodies) == 18
    assert (bodies.parameters[:9] == bodies.parameters[9:]).all()
    assert list(bodies.groups["pose"][:9]) == list(bodies.groups["pose"][9:])
    dose = bodies.covariates["dose"]
    assert not dose[:9].any()
    assert 0 < dose[9:].min() < dose[9:].max() < 1
    areas = [bodies[i].area for i in (2, 11)]
    assert 0 < areas[1] / areas[0] - 1 < 0.05 * 0.04
    plain = Bodies(1, topology=SMALL).make(bodies.parameters[2], str(bodies.groups["pose"][2]))
    np.testing.assert_array_equal(bodies[2].vertices, plain.vertices)
    assert len({bodies.shape_key(i) for i in range(18)}) == 18
    assert bodies.shape_key(0) == Grown("hand", 0.1, n=9, topology=SMALL).shape_key(0)


@pytest.mark.parametrize(("wrong", "named"), [({"place": "nose"}, "place"), ({"area": 0}, "area"), ({"n": 1}, "n"),
                                              ({"others": "none"}, "others")])  # fmt: skip
def test_arguments_out_of_range(wrong, named):
    with pytest.raises(InputError, match=f"collection.{named}="):
        Grown(**{"topology": SMALL} | wrong)
