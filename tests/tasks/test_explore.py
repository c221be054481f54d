"""`task=explore` on shapes in correspondence, and on others."""

from types import SimpleNamespace

import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.errors import InputError
from lssd_learn.pipeline import Pipeline
from lssd_learn.tasks.explore import run


def pieces(shapes, **choices):
    pipeline = Pipeline(ShapeList(shapes), k=16, size=14, keep=9, cache=None, **choices)
    return SimpleNamespace(pipeline=pipeline, operators=["area", "conformal", "extrinsic"], seed=0)


def test_a_page(deformed_spheres, tmp_path):
    metrics = run(pieces(deformed_spheres(15, 1)), tmp_path)
    assert metrics["shapes"] == 15
    assert metrics["error"] < metrics["spread"]
    assert metrics["megabytes"] == pytest.approx((tmp_path / "explore.html").stat().st_size / 1e6)
    assert "15 shapes, moved through by their area, conformal, extrinsic" in (tmp_path / "explore.html").read_text()


def test_of_few_nobody_knows_how_good_it_is(deformed_spheres, tmp_path):
    assert set(run(pieces(deformed_spheres(4, 1)), tmp_path)) == {"shapes", "megabytes"}


def test_shapes_without_correspondence(deformed_spheres, tmp_path):
    def computed(bases, collection):
        return SimpleNamespace(is_identity=False)

    with pytest.raises(InputError, match="^task=explore: expected shapes of the same faces"):
        run(pieces(deformed_spheres(4, 1), maps=computed), tmp_path)
