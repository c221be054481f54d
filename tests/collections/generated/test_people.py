import numpy as np
import pytest

from lssd_learn.collections import Bodies, People
from lssd_learn.collections.generated.body.further import FURTHER_CHANGES
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"


@pytest.fixture(scope="module")
def people():
    return People(n=2000, topology=SMALL)


def slider(people, name):
    return people.sliders[:, people.slider_names.index(name)]


def test_a_longer_collection_begins_with_the_shorter_one(people):
    few = People(n=5, topology=SMALL)
    np.testing.assert_array_equal(few.sliders, people.sliders[:5])
    assert few.shape_key(3) == people.shape_key(3) != People(n=5, topology=SMALL, ages=(20, 30)).shape_key(3)
    assert few.shape_key(3) != Bodies(n=5, topology=SMALL, poses="random", jitter=10).shape_key(3)
    np.testing.assert_array_equal(few[4].vertices, People(n=9, topology=SMALL)[4].vertices)


def test_half_are_women_and_men_are_taller(people):
    woman = slider(people, "gender") > 0.5
    assert 0.46 < woman.mean() < 0.54
    assert slider(people, "gender")[~woman].max() <= 0.15
    few = People(n=40, topology=SMALL)
    heights, women = few.parameters[:, 0], slider(few, "gender") > 0.5
    assert 100 < heights[~women].mean() - heights[women].mean() < 260
    assert 1500 < heights.mean() < 1850


def test_sliders_stay_within_the_model_and_vary(people):
    assert (people.sliders >= 0).all()
    assert (people.sliders <= 1).all()
    assert people.sliders.std(0).min() > 0.02


def test_the_young_are_not_the_old():
    young, old = (People(n=200, topology=SMALL, ages=ages) for ages in ((18, 25), (70, 80)))
    assert slider(young, "age").max() < slider(old, "age").min()


def test_people_may_differ_in_more_than_their_build():
    few, more = (People(n=3, further=further) for further in (0, 0.3))
    build = len(few.slider_names)
    np.testing.assert_array_equal(more.sliders[:, :build], few.sliders)
    assert set(more.slider_names[build:]) == set(FURTHER_CHANGES)
    assert 0.1 < more.sliders[:, build:].std() < 0.2
    assert few.shape_key(0) != more.shape_key(0)
    off = np.linalg.norm(more[1].vertices - few[1].vertices, axis=1)
    assert 0.002 < off.mean() < 0.1
    assert 1 < np.abs(more.parameters - few.parameters)[:, :13].mean() < 100
    with pytest.raises(InputError, match="further: expected a number from 0 to 1, got 2"):
        People(n=1, further=2)


def test_ages_are_years():
    with pytest.raises(InputError, match="ages: expected two numbers of years"):
        People(n=1, ages=(40, 20))
