"""`task=partial_benchmark`, on nets that are hardly trained."""

import csv

import numpy as np
import pytest
import trimesh

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.measures.partial_benchmark import _Truth
from lssd_learn.shapes import Mesh, PointCloud

MIXED = ("collection=mixed", "collection.n=24", "collection.topology=notoes_collapse5pc")
TRAINED = ("task=reconstruction", "basis.k=40", "latent.size=32", "latent.keep=24", "task.points=128")
FEW = (
    "task=partial_benchmark",
    "task.pairs=1",
    "task.validation=1",
    "task.bodies=2",
    "task.points=256",
    "task.thresholds=[0.5,0.8]",
)
METHODS = ("plain", "log_euclidean", "symmetric_0.5", "symmetric_0.8")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("partial")


@pytest.fixture(scope="module")
def program(pieces_of, common_cache):
    """A function (out, overrides) → metrics of a run, on one cache."""

    def run(out, *overrides):
        pieces = pieces_of(out, *overrides, f"cache={common_cache}")
        return pieces.task(pieces, out)

    return run


@pytest.fixture(scope="module")
def vertices(home, program):
    """A checkpoint of net=vertices."""
    program(home / "vertices", *MIXED, *TRAINED, "latent.operators=[area,conformal]", "net=vertices", "net.rounds=2")
    return home / "vertices" / "best.ckpt"


@pytest.fixture(scope="module")
def ran(home, program, vertices):
    """The metrics and the folder of a benchmark of meshes."""
    return program(home / "ran", *FEW, *MIXED, f"ckpt_path={vertices}"), home / "ran"


def test_meshes(ran):
    metrics, folder = ran
    for part in ("test", "validation"):
        assert metrics[f"{part}/own/over_own"] == 1
        for name in (*METHODS, "own", "A", "B"):
            by_role = [metrics[f"{part}/{name}/{role}/cd"] for role in ("body", "pose", "both")]
            assert metrics[f"{part}/{name}/cd"] == pytest.approx(np.mean(by_role))
            assert f"{part}/{name}/new_pose/cd" not in metrics  # all poses are those of the collection
    best = min(METHODS, key=lambda method: metrics[f"validation/{method}/cd"])
    assert metrics["test/best/cd"] == metrics[f"test/{best}/cd"]
    assert metrics["chosen_threshold"] == (0.8 if best == "symmetric_0.8" else 0.5)
    assert metrics["test/own/cd"] < metrics["test/A/cd"]
    # The trivial answers: A is right outside the region and B on it.
    for side, answer, other in (("inside", "B", "A"), ("outside", "A", "B")):
        right, wrong = (metrics[f"test/{name}/vertex_error_mm_{side}"] for name in (answer, other))
        assert right < 0.3 * wrong
        assert metrics[f"test/{answer}/cd_{side}"] < metrics[f"test/{other}/cd_{side}"]
    with (folder / "partial.csv").open(encoding="utf-8") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == 3 * (1 + 1) * 7
    assert (folder / "partial.png").read_bytes()[:4] == b"\x89PNG"


def test_what_is_written_opens_elsewhere_and_stands_upright(ran, program, vertices, tmp_path):
    """In trimesh: PLY with z up as the shapes themselves, GLB with y up."""
    bodies = ("collection=mixed", *MIXED[1:], f"ckpt_path={vertices}", "task.a=body_0000", "task.b=body_0002")
    program(tmp_path / "path", "task=interpolation", *bodies, "task.steps=3")
    program(tmp_path / "analogy", "task=analogy", *bodies, "task.c=body_0001", "task.region=upper_body")
    files = [*ran[1].rglob("*.ply"), *tmp_path.rglob("*.ply")]
    assert {file.parts[-2] for file in files} == {"shapes", "linear", "log_euclidean"}
    parts = Bodies(1, topology="notoes_collapse5pc").parts
    head, legs = parts["head"], parts["left_leg"] | parts["right_leg"]
    for file in files:
        mesh = trimesh.load(file, process=False)
        shown = trimesh.load(file.with_suffix(".glb"), process=False, force="mesh")
        for made, up in ((mesh, 2), (shown, 1)):
            assert made.vertices.shape == (615, 3)
            assert len(made.faces) == 1226
            assert made.vertices[head, up].mean() > made.vertices[legs, up].mean() + 0.3
        np.testing.assert_allclose(shown.vertices[:, 1], mesh.vertices[:, 2], atol=1e-5)


def test_clouds_and_poses_that_training_has_not_seen(program, home, tmp_path):
    program(home / "cloud", *MIXED, *TRAINED, "task.epochs=1")
    others = ("collection=bodies_small", f"ckpt_path={home / 'cloud' / 'best.ckpt'}", "task.region=lower_body")
    metrics = program(tmp_path, *FEW, *others)
    assert "test/own/vertex_error_mm" not in metrics
    assert "test/A/vertex_error_mm" in metrics
    assert metrics["test/own/new_pose/cd"] > 0


def test_sides_are_scored_apart():
    bodies = Bodies(1, topology="notoes_collapse5pc")
    mesh, mask = bodies.make({}, "rest"), bodies.parts["upper_body"]
    truth = _Truth(mesh, mask, 2000, 0)
    same = truth.score(PointCloud(truth.cloud))
    assert same == {"cd": 0, "cd_inside": 0, "cd_outside": 0}
    moved = np.where(mask[:, None], mesh.vertices + [0, 0.03, 0], mesh.vertices)
    scores = truth.score(Mesh(moved, mesh.faces))
    assert scores["vertex_error_mm_inside"] == pytest.approx(30)
    assert scores["vertex_error_mm_outside"] == 0
    assert scores["vertex_error_mm"] == pytest.approx(30 * mask.mean())
    assert scores["cd_inside"] > scores["cd"] > scores["cd_outside"] > 0
    nowhere = truth.score(PointCloud(mesh.vertices[~mask]))  # nothing near most of the region
    assert nowhere["cd_inside"] > 10 * nowhere["cd_outside"]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("task.region=left_arm",), "task.region=left_arm: expected one of upper_body, lower_body"),
        (("task.seed=0",), "task.seed=0: expected another than collection.seed"),
        (("task.bodies=1",), "task.bodies=1"),
        (("task.thresholds=[1.0]",), "task.thresholds: expected parts of 1, 0 or more and below 1, got 1.0"),
        (("collection=bumps",), "expected generated bodies"),
    ],
)
def test_mistakes_are_told(program, tmp_path, overrides, message):
    collection = () if overrides[0] == "collection=bumps" else MIXED
    with pytest.raises(InputError, match=message):
        program(tmp_path, *FEW, *collection, *overrides)
