"""`task=landmark_stability` on spheres with bumps, read from a folder without their correspondence."""

import numpy as np
import pytest
import trimesh
from pictures import coloured

from lssd_learn.collections import Bumps
from lssd_learn.errors import InputError
from lssd_learn.view import highlights

SMALL = ("task=landmark_stability", "collection=folder", "collection.correspondence=none", "network=spanning_tree",
         "basis.k=30", "latent.size=25", "latent.keep=16", "parallel.workers=1", "task.permutations=9",
         "task.shown=1")  # fmt: skip
COMPUTED = ("maps=adjoint", "maps.functions=25", "maps.trusted=16", "maps.refined=25")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six spheres with a bump on top in half of them and one of any height at the side, and twenty landmarks."""
    path = tmp_path_factory.mktemp("spheres")
    heights = np.stack([np.random.default_rng(0).uniform(0, 0.3, 6), np.repeat([0, 0.25], 3)], axis=1)
    spheres = Bumps(heights=heights, subdivisions=3)
    marks = list(range(12)) + list(range(50, 130, 10))
    lines = ["name,landmark,vertex"]
    for name, mesh in zip(spheres.names, spheres, strict=True):
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path / f"{name}.ply")
        lines += [f"{name},{j},{vertex}" for j, vertex in enumerate(marks)]
    (path / "landmarks.csv").write_text("\n".join(lines) + "\n")
    (path / "labels.csv").write_text(
        "name,set\n" + "".join(f"{n},{'AB'[i // 3]}\n" for i, n in enumerate(spheres.names))
    )
    return path


@pytest.fixture
def run(runs_of, folder, monkeypatch):
    """A function (overrides) → metrics."""
    monkeypatch.setattr(highlights, "LARGEST", 80)
    return runs_of(*SMALL, f"collection.path={folder}", network="spanning_tree")


def test_more_and_fewer_landmarks_and_these_alone(run, tmp_path):
    metrics = run(*COMPUTED, "task.landmarks=[12,20]")
    assert metrics["shapes"] == 6
    assert metrics["20/region"] == metrics["20/function"] == pytest.approx(1)
    assert metrics["12/region"] > 0.8
    assert metrics["20/template"] > 0.3
    assert coloured(tmp_path / "highlighted.png") > 0.05  # .12 here
    fields = {file.name.split("_", 2)[2] for file in (tmp_path / "shapes").iterdir()}
    assert fields == {"landmarks_12.ply", "landmarks_20.ply", "template.ply"}


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.landmarks=[6]"], r"task.landmarks=\[6\]: expected two numbers or more, ascending"),
        (["task.landmarks=[12,6]"], "expected two numbers or more, ascending"),
        (["task.landmarks=[6,30]", "maps=landmarks"], "maps.landmarks=30: expected a whole number, 3 to 20"),
        (["task.shown=0"], "task.shown=0: expected a whole number, 1 or more"),
        ([], "maps: expected maps that are computed from landmarks, maps=spline, adjoint or landmarks"),
    ],
)
def test_mistakes(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run(*overrides)
