"""`task=agreement` on spheres with bumps and small clouds."""

import logging

import numpy as np
import pytest
import trimesh
from pictures import coloured

from lssd_learn import maps
from lssd_learn.errors import InputError
from lssd_learn.studies import agreement_chart as agreement

SPHERES = ("task=agreement", "collection=bumps", "collection.subdivisions=3", "maps=kernel_matching",
           "maps.correspondence=none", "maps.samples=200", "basis.k=40", "latent.size=32",
           "latent.keep=24", "task.shown=1", "task.relabelled=3", "parallel.workers=1")  # fmt: skip
CLOUDS = ("experiment=paper_clouds", "collection.topology=notoes_collapse5pc", "collection.points=600", "basis.k=30",
          "collection.poses=[rest,sitting]", "maps.functions=30", "maps.trusted=20", "maps.refined=20",
          "latent.size=24", "latent.keep=8", "task.shown=1", "parallel.workers=1")  # fmt: skip


@pytest.fixture
def run(runs_of, monkeypatch):
    """A function (overrides) → metrics."""
    monkeypatch.setattr(agreement, "LARGEST", 100)  # small pictures are quick ones
    return runs_of()


def test_computed_maps_that_are_right_agree_with_true_ones(run, tmp_path, caplog, monkeypatch):
    identity = np.arange(642)
    monkeypatch.setattr(maps.KernelMatchingMaps, "vertex_maps", lambda *_: (identity, identity))
    with caplog.at_level(logging.INFO):
        found = run(*SPHERES, "latent.operators=[area,conformal]")
    for kind in ("area", "conformal"):
        assert found[f"{kind}/region"] == pytest.approx(1, abs=1e-6)
        assert found[f"{kind}/function/lowest"] == pytest.approx(1, abs=1e-6)
    assert found["area/chance"] < 0.9
    assert coloured(tmp_path / "agreement.png") > 0.05  # .09 here
    files = {f"{kind}_{side}" for kind in ("area", "conformal") for side in ("true", "computed")}
    assert {file.name[10:-4] for file in (tmp_path / "shapes").iterdir()} == files
    assert any("area: where the groups differ 1.000, lowest 1.000" in line for line in caplog.messages)


def test_wrong_maps_do_not(run, monkeypatch):
    order = np.random.default_rng(0).permutation(642)
    monkeypatch.setattr(maps.KernelMatchingMaps, "vertex_maps", lambda *_: (order, np.argsort(order)))
    found = run(*SPHERES, "task.relabelled=0")
    assert set(found) == {"shapes"} | {
        f"area/{name}{low}" for name in ("region", "function") for low in ("", "/lowest")
    }
    assert found["area/region"] < 0.6


def test_clouds_are_compared_with_their_meshes(run, tmp_path):
    found = run(*CLOUDS)
    assert found["shapes"] == 4
    assert found["area/chance"] + 0.1 < found["area/region"] < 1  # coarse clouds: some of it is seen
    cloud = trimesh.load(tmp_path / "shapes" / "slim_rest_area_computed.ply")
    assert len(cloud.vertices) == 600


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ([*SPHERES, "maps.correspondence=auto"], "maps: expected computed ones, such as"),
        (["task=agreement", "collection=bumps", "collection.subdivisions=2"], "maps: expected computed ones, such as"),
        ([*SPHERES, "task.shown=0"], "task.shown=0: expected a whole number, 1 or more"),
        ([*SPHERES, "task.relabelled=-1"], "task.relabelled=-1: expected a whole number, 0 or more"),
    ],
)
def test_mistakes(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run(*overrides)


def test_shapes_without_a_truth(run, small_mesh_folder):
    (small_mesh_folder / "labels.csv").write_text(
        "name,kind\n" + "".join(f"shape_{i},{'ab'[i > 2]}\n" for i in range(5))
    )
    with pytest.raises(InputError, match="collection: expected shapes whose true correspondence is known"):
        run(*SPHERES[-6:], "task=agreement", "collection=folder", f"collection.path={small_mesh_folder}",
            "maps=kernel_matching", "collection.correspondence=none")  # fmt: skip
