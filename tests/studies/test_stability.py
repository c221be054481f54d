"""`task=stability` on deformed spheres and small bodies."""

import json
from functools import partial

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.collections import ShapeList
from lssd_learn.errors import InputError
from lssd_learn.maps import PairMaps
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import PointCloud

SMALL = ("task=stability", "basis.k=40", "latent.size=32", "latent.keep=20", "task.full_k=120", "task.full_size=80",
         "task.functions=10", "parallel.workers=1")  # fmt: skip


@pytest.fixture
def pieces(tmp_path, monkeypatch):
    """A function (collection, overrides) → the pieces of a run on it."""
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))

    def make(collection, *overrides):
        with initialize_config_dir(str(conf()), version_base="1.3"):
            config = OmegaConf.to_container(compose("config", overrides=[*SMALL, *overrides]), resolve=True)
        config["collection"] = {"_target_": "builtins.dict"}
        choices = dict.fromkeys(("collection", "network", "net"), "")

        def build(node):
            return collection if node is config["collection"] else instantiate(node)

        return Pieces.from_config(config, choices, build, tmp_path, "")

    return make


def test_the_canonical_basis_stays_and_the_latent_shape_is_the_average(pieces, spheres, tmp_path, caplog):
    with caplog.at_level("INFO"):
        run = pieces(spheres())
        found = run.task(run, tmp_path)
    assert (found["shapes"], found["added"]) == (6, 1)
    assert found["canonical/off_band"] < found["plain/off_band"] / 4
    assert found["ratio/off_band"] == pytest.approx(found["plain/off_band"] / found["canonical/off_band"])
    assert found["canonical/off_band"] < found["canonical/off_diagonal"] < found["plain/off_diagonal"]
    assert found["canonical/angle"] < found["plain/angle"]
    assert found["average/spectrum_mean"] <= found["average/spectrum"] < 0.02
    assert found["average/off_band"] < 0.01
    json.dumps(found)
    assert (tmp_path / "stability.png").stat().st_size > 20_000
    with np.load(tmp_path / "matrices.npz") as arrays:
        assert {name: arrays[name].shape for name in ("plain", "canonical", "average", "average_shape")} == {
            "plain": (20, 20), "canonical": (20, 20), "average": (10, 10), "average_shape": (10,),
        }  # fmt: skip
    assert "stability.png" in caplog.messages[-1]
    assert any("canonical:" in line and "times less" in line for line in caplog.messages)


def test_nothing_turns_where_nothing_new_comes(pieces, meshes, tmp_path):
    run = pieces(ShapeList([*meshes[:3], *meshes[:3]]), "task.added=3", "task.full_k=null")
    found = run.task(run, tmp_path)
    assert found["canonical/off_diagonal"] < 1e-10
    assert found["canonical/angle"] < 1e-3


def test_shapes_without_common_faces_have_no_average(pieces, meshes, tmp_path, monkeypatch):
    clouds = ShapeList([PointCloud(mesh.vertices) for mesh in meshes[:3]])
    run = pieces(clouds, "task.full_k=50", "task.full_size=40")
    object.__setattr__(run.pipeline, "maps", partial(_Indices))
    assert "average/spectrum" not in run.task(run, tmp_path)


class _Indices(PairMaps):
    """Point v is point v, which the clouds themselves do not say."""

    is_identity = False

    def __call__(self, i, j):
        a, b = self._bases[i], self._bases[j]
        return (b.evecs * b.mass[:, None]).T @ a.evecs


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("task.added=5", "task.added=5: expected a whole number, 1 to 4"),
        ("task.band=-1", "task.band=-1: expected a whole number, 0 or more"),
        ("task.functions=90", "task.functions=90: expected a whole number, 2 to 80"),
        ("task.full_size=130", "task.full_size=130: expected a whole number, 2 to 120"),
        ("task.full_k=162", "task.full_k=162: expected fewer than the 162 vertices of a shape"),
    ],
)
def test_mistakes(pieces, spheres, tmp_path, override, message):
    run = pieces(spheres(), override)
    with pytest.raises(InputError, match=message):
        run.task(run, tmp_path)
