import numpy as np
import pytest

from lssd_learn.collections import Bodies, Faulty, Remeshed
from lssd_learn.collections.generated.faulty import FAULTS
from lssd_learn.errors import InputError
from lssd_learn.shapes.triangles import enclosed


@pytest.fixture(scope="module")
def bodies():
    return Bodies(n=8, topology="notoes_collapse10pc")


def test_each_kind_does_what_it_says_and_nothing_else(bodies):
    scans = Faulty(bodies, seed=1)
    assert scans.groups["fault"].tolist() == [*FAULTS, *FAULTS]
    for i, (before, after) in enumerate(zip(bodies, scans, strict=True)):
        if scans.fault(i) in ("noise", "bumps"):
            away = np.linalg.norm(after.vertices - before.vertices, axis=1)
            assert (after.faces == before.faces).all()
            assert 0 < away.mean() < 0.02
            if scans.fault(i) == "bumps":
                assert enclosed(after.vertices[after.faces]) > enclosed(before.vertices[before.faces])
        else:
            assert 0.5 < len(after.vertices) / len(before.vertices) < 1
            assert set(map(tuple, after.vertices)) <= set(map(tuple, before.vertices))


def test_what_is_known_of_the_shapes_stays_known_and_they_are_the_same_each_time(bodies):
    one, other = Faulty(bodies), Faulty(bodies)
    np.testing.assert_array_equal(one.parameters, bodies.parameters)
    assert one.names == bodies.names
    for i in (0, 1, 2, 3):
        np.testing.assert_array_equal(one[i].vertices, other[i].vertices)
    assert one.key == other.key != Faulty(bodies, seed=1).key
    assert one.shape_key(0) != one.shape_key(1)
    assert one.shape_key(0) != Faulty(bodies, faults=["holes"]).shape_key(0)


def test_what_cannot_be_is_refused(bodies):
    with pytest.raises(InputError, match="collection.faults="):
        Faulty(bodies, faults=["rust"])
    with pytest.raises(InputError, match="body_0000: expected a mesh, got a cloud"):
        Faulty(Remeshed(bodies, kind="cloud", vertices=(500, 500)))[0]
