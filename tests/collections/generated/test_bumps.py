import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.collections import Bumps
from lssd_learn.errors import InputError


def radii(mesh):
    return np.linalg.norm(mesh.vertices, axis=1)


def test_the_four_spheres_of_the_paper():
    spheres = Bumps()
    assert (len(spheres), spheres.names[1], spheres.up) == (4, "sphere_01", "z")
    assert spheres.parameter_names == ["side", "top"]
    plain, side, top, both = (radii(mesh) for mesh in spheres)
    np.testing.assert_allclose(plain, 1, atol=1e-12)
    assert (side.max(), top.max(), both.max()) == pytest.approx((1.5, 1.25, 1.5), abs=1e-3)
    np.testing.assert_allclose(both - 1, side - 1 + top - 1, atol=1e-12)
    assert spheres[3].vertices[top.argmax()] == pytest.approx([0, 0, 1.25], abs=0.1)
    assert spheres[0].connectivity == spheres[3].connectivity


def test_a_bump_ends_at_its_width():
    (bump,) = Bumps({"nose": (0, -3, 0)}, [[0.4]], [30], subdivisions=3)
    (part,) = Bumps({"nose": (0, -3, 0)}, [[0.4]], [30], subdivisions=3).parts.values()
    angles = np.degrees(np.arccos(-bump.vertices[:, 1] / radii(bump)))
    np.testing.assert_array_equal(radii(bump) > 1 + 1e-9, angles < 30 - 1e-6)
    np.testing.assert_array_equal(part, angles < 30 - 1e-6)
    half = 30 * np.sqrt(1 - np.sqrt(0.5))  # where (1 − (θ/w)²)² is one half
    assert radii(bump)[angles < half].min() > 1.2 > radii(bump)[angles > half].max()


def test_the_configuration_is_the_default_with_its_groups():
    spheres = instantiate(OmegaConf.load(conf() / "collection" / "bumps.yaml"))
    assert spheres.groups["set"].tolist() == list("AABB")
    assert spheres.key == Bumps().key
    np.testing.assert_array_equal(spheres.parameters, Bumps().parameters)


def test_keys_hold_all_that_makes_a_sphere_and_nothing_else():
    first = Bumps()
    longer = Bumps(heights=[*first.parameters.tolist(), [0.1, 0.1]])
    assert first.shape_key(2) == longer.shape_key(2) != first.shape_key(1)
    others = [longer, Bumps(widths=(40, 41)), Bumps(subdivisions=3), Bumps({"side": (1, 0, 0.1), "top": (0, 0, 1)})]
    assert len({first.key, *(other.key for other in others)}) == 5
    assert Bumps(groups={"x": [1, 2, 3, 4]}).key == first.key


def test_the_sequence_ends():
    spheres = Bumps()
    np.testing.assert_array_equal(spheres[-1].vertices, spheres[3].vertices)
    with pytest.raises(IndexError):
        spheres[4]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"subdivisions": 8}, "subdivisions=8: expected a whole number, 0 to 7"),
        ({"places": {"a": (0, 0, 0), "b": (1, 0, 0)}}, r"places: expected a direction, a is \(0, 0, 0\)"),
        ({"places": {"a": (0, 1), "b": (1, 0)}}, r"places: expected 2 × 3 finite numbers, got an array of \(2, 2\)"),
        ({"heights": [[0.1]]}, r"heights: expected n × 2 finite numbers, got an array of \(1, 1\)"),
        ({"heights": [[0.1, 0], [0]]}, "heights: expected rows of as many numbers"),
        ({"heights": [[0.1, float("nan")]]}, "heights: expected n × 2 finite numbers"),
        ({"heights": []}, "heights: expected n × 2 finite numbers"),
        ({"heights": [[0, -1.2]]}, "heights: expected bumps that leave a radius above 0, together they leave -0.2"),
        ({"widths": [30]}, r"widths: expected 2 finite numbers"),
        ({"widths": [30, 0]}, "widths=0.0: expected a number above 0"),
        ({"widths": [30, 200]}, "widths: expected degrees up to 180, got 200"),
        ({"groups": {"set": [1, 2]}}, "groups: expected a label of set for each of 4 spheres, got 2"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        Bumps(**arguments)
