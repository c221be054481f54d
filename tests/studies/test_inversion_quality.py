"""`task=inversion_quality`: shapes that the space was not fitted to, sought from their operators."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.division.protocols import Division
from lssd_learn.errors import InputError
from lssd_learn.pipeline import Pipeline
from lssd_learn.studies.inversion_quality import run


@pytest.fixture
def pieces(deformed_spheres):
    """A function fitted → pieces of ten deformed spheres of two labels, of which these make the latent space."""
    shapes = ShapeList(deformed_spheres(10, 1))
    shapes.groups = {"side": np.array(["left", "right"] * 5)}

    def made(fitted):
        pipeline = Pipeline(shapes, k=16, size=14, keep=10, fitted=fitted, cache=None)
        kinds = ["area", "conformal", "extrinsic"]
        return SimpleNamespace(pipeline=pipeline, seed=0, data=Division(), operators=kinds)

    return made


def test_found_is_nearer_than_where_it_started(pieces, tmp_path):
    metrics = run(pieces(range(7)), tmp_path, group="side", shapes=2)
    assert metrics["found/mean"] < 0.7 * metrics["start/mean"]
    with (tmp_path / "inversion_quality.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["side"] for row in rows] == ["left", "right"]
    assert max(float(row["found"]) for row in rows) == pytest.approx(metrics["found/worst"], rel=1e-4)
    assert float(rows[0]["found"]) == pytest.approx(metrics["found/left"], rel=1e-4)


def test_what_is_asked_for_has_to_be_there(pieces, tmp_path):
    with pytest.raises(InputError, match="^task=inversion_quality: expected latent.fitted=…, less than all shapes"):
        run(pieces(None), tmp_path, group="side")
    with pytest.raises(InputError, match="^task.labels=top: expected a side of shapes fitted and not"):
        run(pieces(range(7)), tmp_path, labels=["left", "top"], group="side")
