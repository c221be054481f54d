import numpy as np
import pytest

from lssd_learn.nets import chamfer
from lssd_learn.shapes.nearest import Indexed


def test_the_distance_of_clouds_is_that_of_the_nets():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(50, 3)), rng.normal(size=(70, 3)).astype(np.float32)
    assert Indexed(a).chamfer(Indexed(b)) == pytest.approx(float(chamfer(a, b)), rel=1e-12)
    assert Indexed(b).chamfer(Indexed(a)) == pytest.approx(float(chamfer(a, b)), rel=1e-12)
    distances, found = Indexed(b).nearest(a)
    np.testing.assert_allclose(np.linalg.norm(a - b[found], axis=1), distances)
    np.testing.assert_array_equal(Indexed(b).distances(a), distances)
    assert (len(Indexed(b)), Indexed(b).distances(b).max()) == (70, 0)
