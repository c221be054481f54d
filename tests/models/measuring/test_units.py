import numpy as np
import pytest

from lssd_learn.collections import People
from lssd_learn.errors import InputError
from lssd_learn.models.measuring.units import METRES, find_unit, in_metres
from lssd_learn.shapes import Mesh, PointCloud


@pytest.fixture(scope="module")
def people():
    return list(People(n=24, topology="notoes_collapse5pc", poses="eight"))


@pytest.mark.parametrize("unit", METRES)
def test_the_unit_is_found_in_every_pose_and_taken_out(people, unit):
    for body in people:
        scan = Mesh(body.vertices / METRES[unit], body.faces)
        assert find_unit(scan) == unit == find_unit(PointCloud(scan.points)) == find_unit(scan, unit)
        np.testing.assert_allclose(in_metres(scan, unit).points, body.points)


def test_another_size_is_refused_in_a_line_that_says_what_it_may_be(people):
    inches = Mesh(people[0].vertices / 0.0254, people[0].faces)
    with pytest.raises(InputError, match="of no grown-up's size in any"):
        find_unit(inches)
    with pytest.raises(InputError, match="in mm, but it is of no grown-up's size in that; it seems to be in m"):
        find_unit(people[0], "mm")
    with pytest.raises(InputError, match="unit=feet: expected one of auto, m, cm, mm"):
        find_unit(people[0], "feet")
