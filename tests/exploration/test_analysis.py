import numpy as np
import pytest

from lssd_learn.collections import Bumps, ShapeList, eigenbases
from lssd_learn.collections.groups import choose_groups
from lssd_learn.errors import InputError
from lssd_learn.exploration import cross_collection
from lssd_learn.exploration.analysis import analyse
from lssd_learn.latent import LatentSpace, MapNetwork


@pytest.fixture(scope="session")
def grouped():
    """A function (labels) → a collection grouped by `kind`."""

    def make(labels, name="kind"):
        shapes = ShapeList([])
        shapes.groups = {name: np.array(labels, dtype=object)}
        return shapes

    return make


def test_all_labels_are_compared(grouped):
    groups = choose_groups(grouped(["b", "a", "b", "a"]))
    assert (groups.name, groups.labels, groups.of) == ("kind", ["a", "b"], ["b", "a", "b", "a"])
    assert groups.members("a").tolist() == [1, 3]


def test_two_of_the_labels_in_the_order_asked_for_and_others_are_left_out(grouped):
    groups = choose_groups(grouped([3, 1, 2, 3, 1]), labels=[3, 1])
    assert (groups.labels, groups.of, groups.shapes.tolist()) == (["3", "1"], ["3", "1", "3", "1"], [0, 1, 3, 4])


@pytest.mark.parametrize("unknown", [None, "", np.nan])
def test_shapes_of_unknown_group_stay_without_a_label(grouped, unknown):
    groups = choose_groups(grouped(["a", unknown, "b", "?", "a", "b"]), unlabelled="?")
    assert groups.of == ["a", None, "b", None, "a", "b"]
    assert groups.shapes.tolist() == list(range(6))


@pytest.mark.parametrize(
    ("labels", "arguments", "message"),
    [
        (["a", "a"], {}, "task.group=kind: expected two labels or more to compare, got a"),
        (["a", "a", "b"], {}, "task.group=kind: expected two shapes or more of each label, got one of 'b'"),
        (["a", "a", "b", "b"], {"labels": ["a", "c"]}, r"task.labels=\[a,c\]: kind has no label 'c'; it has a, b"),
        (["a", "a", "b", "b"], {"labels": ["a", "a"]}, r"task.labels=\[a,a\]: expected two labels or more"),
        (["a", "a", "b", "b"], {"group": "size"}, "task.group=size: expected one of kind"),
        (["", None], {}, "task.group=kind: expected two labels or more to compare, got none"),
    ],
)
def test_bad_groups(grouped, labels, arguments, message):
    with pytest.raises(InputError, match=message):
        choose_groups(grouped(labels), **arguments)


@pytest.fixture(scope="module")
def bumpy():
    """Twelve spheres with a low bump on top in half of them, and one of any height at the side; their operators."""
    heights = np.stack([np.random.default_rng(0).uniform(0, 0.5, 12), np.repeat([0, 0.25], 6)], axis=1)
    bases = eigenbases(Bumps(heights=heights, subdivisions=3), 40, cache=None, workers=1)
    latent = LatentSpace.fit(MapNetwork.clique(bases), 32, 24)
    return latent, latent.differences()[0]


def test_an_analysis_knows_which_group_is_larger_there(bumpy, grouped):
    latent, D = bumpy
    labels = ["flat"] * 6 + ["high"] * 6
    found = analyse("area", latent, D, choose_groups(grouped(labels)), permutations=99)
    assert found.sizes["flat"] < 0.9 < 1.1 < found.sizes["high"]
    assert found.metrics["p_value"] == 0.01
    assert found.metrics["accuracy/after"] == 1
    assert found.metrics["silhouette/after"] > 0.8 > found.metrics["silhouette/before"]
    assert all(np.isfinite(value) for value in found.metrics.values())
    np.testing.assert_allclose(found.alpha, cross_collection(D, labels, 2), atol=1e-12)
    assert found.before.points.shape == found.after.points.shape == (12, 2)


def test_shapes_left_out_change_nothing(bumpy, grouped):
    latent, D = bumpy
    labels = ["flat"] * 6 + ["high"] * 4
    groups = choose_groups(grouped([*labels, "other", "other"]), labels=["flat", "high"])
    found = analyse("area", latent, D, groups, permutations=9)
    np.testing.assert_allclose(found.alpha, cross_collection(D[:-2], labels, 2), atol=1e-12)
    assert len(found.before.points) == 10


def test_shapes_of_unknown_group_are_only_embedded(bumpy, grouped):
    latent, D = bumpy
    labels = ["flat"] * 6 + ["high"] * 4
    found = analyse("area", latent, D, choose_groups(grouped([*labels, "", ""])), permutations=9)
    np.testing.assert_allclose(found.alpha, cross_collection(D[:-2], labels, 2), atol=1e-12)
    assert len(found.after.points) == 12
    high = found.after.points[6:, 0]
    assert len(set(high.sign().tolist())) == 1  # the two that nobody named lie with their like
