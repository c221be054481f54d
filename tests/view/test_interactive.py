"""With polyscope's backend that draws nothing, where polyscope is installed."""

import importlib

import numpy as np
import pytest

from lssd_learn.collections import Bumps
from lssd_learn.errors import InputError
from lssd_learn.shapes import PointCloud
from lssd_learn.view.fields import Field
from lssd_learn.view.interactive import polyscope, show


def test_a_clear_line_where_it_is_not_installed(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(InputError, match=r"needs polyscope: pip install 'lssd_learn\[polyscope\]'"):
        polyscope()


def test_shapes_stand_side_by_side_with_their_fields():
    ps = pytest.importorskip("polyscope")
    spheres = Bumps(subdivisions=2)
    shapes = [spheres[0], PointCloud(spheres[1].vertices), spheres[3]]
    heights = [shape.points[:, 2] for shape in shapes]
    fields = [Field.positive("up", "height", [np.abs(h) for h in heights]), Field.signed("side", "signed", heights)]
    show(shapes, ["one", "cloud", "three"], fields, "z", backend="openGL_mock", frames=1)
    assert ps.has_surface_mesh("one")
    assert ps.has_surface_mesh("three")
    assert ps.has_point_cloud("cloud")
    show(shapes[:1], ["one"], [f for f in fields if f.name == "none"], "z", backend="openGL_mock", frames=1)
    assert not ps.has_point_cloud("cloud")
