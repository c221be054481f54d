"""`task=reconstruction`: shapes come back out of their operators, as meshes and as clouds."""

import csv

import numpy as np
import pytest
import torch
import trimesh
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.collections import Bodies
from lssd_learn.division.split import split
from lssd_learn.errors import InputError
from lssd_learn.learning.scores.reconstructed import NearestPose, means
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh, PointCloud, load, sample, save

SMALL = ("task=reconstruction", "collection=bodies_small", "basis.k=40", "latent.size=32", "latent.keep=24")
SCORES = {"cd", "cd_over_level", "f_1cm", "f_2cm"}


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("reconstruction")


@pytest.fixture(scope="module")
def program(common_cache):
    """A function (out, overrides) → the metrics of a run of this process, on one cache."""

    def run(out, *overrides):
        with initialize_config_dir(str(conf()), version_base="1.3"):
            overrides = [*map(str, overrides), f"cache={common_cache}"]
            overrides += ["task.points=256"] if "task=reconstruction" in overrides else []
            config = OmegaConf.to_container(compose("config", overrides=overrides), resolve=True)
        choices = dict.fromkeys(("collection", "network"), "") | {"net": config["net"]["_target_"].split(".")[-1]}
        out.mkdir(exist_ok=True)
        pieces = Pieces.from_config(config, choices, instantiate, out, "python train.py again")
        return pieces.task(pieces, out)

    return run


def rows(path):
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_meshes_come_back_where_vertices_correspond(program, tmp_path, caplog):
    with caplog.at_level("INFO"):
        metrics = program(tmp_path, *SMALL, "net=vertices", "latent.operators=[area,conformal]", "task.shown=3")
    for name in ("test", "reference/mean", "reference/nearest"):
        assert {f"{name}/{key}" for key in SCORES | {"vertex_error_mm", "pose_agreement"}} <= metrics.keys()
    assert next(iter(metrics)) == "test/cd"
    assert metrics["test/vertex_error_mm"] == pytest.approx(1000 * metrics["test/vertex_error"], rel=1e-4)
    assert metrics["test/vertex_error_mm"] < 0.5 * metrics["reference/mean/vertex_error_mm"]
    assert metrics["test/cd"] < metrics["reference/nearest/cd"] < metrics["reference/mean/cd"]
    assert metrics["test/pose_agreement"] > metrics["reference/mean/pose_agreement"]
    assert "mean of the training split" in caplog.text

    table = rows(tmp_path / "scores.csv")
    test = split(40, 0).test
    assert [row["name"] for row in table if row["answer"] == "net"] == [f"body_{i:04d}" for i in test]
    cds = [float(row["cd"]) for row in table if row["answer"] == "mean"]
    assert np.mean(cds) == pytest.approx(metrics["reference/mean/cd"], rel=1e-4)
    assert (tmp_path / "reconstruction.png").read_bytes()[:4] == b"\x89PNG"
    assert len(list((tmp_path / "reconstructions").iterdir())) == 12
    faces = torch.load(tmp_path / "best.ckpt", weights_only=True)["faces"]
    assert np.array_equal(faces, Bodies(1, topology="notoes_collapse5pc")[0].faces)


def test_files_stand_upright_and_keep_faces_and_order(program, tmp_path):
    program(tmp_path, *SMALL, "net=vertices", "net.rounds=1", "task.shown=1")
    truth_file, ply = sorted((tmp_path / "reconstructions").glob("*.ply"), key=lambda path: "truth" not in path.name)
    body = Bodies(40, topology="notoes_collapse5pc")[int(ply.stem[-4:])]
    truth, drawn = load(truth_file), load(ply)
    np.testing.assert_allclose(truth.vertices, body.vertices, atol=1e-6)
    assert np.array_equal(drawn.faces, body.faces)
    viewed = load(ply.with_suffix(".glb"))
    np.testing.assert_allclose(viewed.vertices[:, 1], drawn.vertices[:, 2], atol=1e-6)
    assert np.ptp(trimesh.load_mesh(ply.with_suffix(".glb")).vertices[:, 1]) > 0.7


@pytest.mark.slow
def test_clouds_come_back_and_a_resumed_run_ends_alike(program, tmp_path):
    whole = program(tmp_path / "whole", *SMALL, "task.epochs=4", "task.milestones=[2]", "data.standardise=none")
    program(tmp_path / "cut", *SMALL, "task.epochs=2", "task.milestones=[2]", "data.standardise=none")
    resumed = program(
        tmp_path / "cut", *SMALL, "task.epochs=4", "task.milestones=[2]", "data.standardise=none", "ckpt_path=last"
    )
    assert {k: v for k, v in whole.items() if "seconds" not in k} == {
        k: v for k, v in resumed.items() if "seconds" not in k
    }
    assert "test/cd@2" in whole
    assert "test/vertex_error_mm" not in whole
    assert whole["reference/mean/vertex_error_mm"] > 100
    assert torch.load(tmp_path / "cut" / "best.ckpt", weights_only=True)["faces"] is None
    cloud = load(next((tmp_path / "cut" / "reconstructions").glob("*[0-9].ply")))
    assert isinstance(cloud, PointCloud)
    assert len(cloud.points) == 256


def test_an_auto_encoder_sees_the_cloud(program, tmp_path):
    out = tmp_path / "a"
    metrics = program(out, *SMALL, "net=autoencoder", "task.epochs=30", "data.points=256", "data.augment=resample")
    assert metrics["test/cd"] < metrics["reference/mean/cd"]
    assert torch.load(out / "best.ckpt", weights_only=True)["points"] == 256
    with pytest.raises(InputError, match="augment=turn"):
        program(tmp_path / "b", *SMALL, "net=autoencoder", "data.augment=both")


def test_without_common_faces_there_is_a_shape_in_the_middle(program, deformed_spheres, tmp_path):
    folder = tmp_path / "shapes"
    (folder / "maps").mkdir(parents=True)
    for i, mesh in enumerate(deformed_spheres(12, 2)):
        save(mesh if i else Mesh(mesh.vertices, mesh.faces[::-1]), folder / f"s{i:02d}.ply")
        if i:
            for a, b in ((i - 1, i), (i, i - 1)):
                np.savetxt(folder / "maps" / f"s{a:02d}__s{b:02d}.txt", np.arange(162), "%d")
    small = ("task=reconstruction", "collection=folder", f"collection.path={folder}", "network=chain", "basis.k=12")
    small = (*small, "latent.size=10", "latent.keep=8", "task.epochs=1", "net.layers=[[4,3,2]]")
    metrics = program(tmp_path / "out", *small)
    assert {f"reference/middle/{key}" for key in SCORES} <= metrics.keys()
    assert "reference/mean/cd" not in metrics
    assert not any("pose_agreement" in key for key in metrics)
    with pytest.raises(InputError, match="net=vertices: expected shapes that all have the same faces"):
        program(tmp_path / "out", *small[:-1], "net=vertices")


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("task=reconstruction", "net=cnn"), "net=CNN: expected one that draws shapes"),
        (("task=regression", "net=reconstructor"), "expected a net that gives numbers, this one gives clouds"),
        (("task=regression", "net=vertices"), "expected a net that gives numbers, this one gives vertices"),
    ],
)
def test_nets_of_other_tasks_are_refused(program, tmp_path, overrides, message):
    with pytest.raises(InputError, match=message):
        program(tmp_path, *SMALL[1:], *overrides)


def test_clouds_have_no_surface_to_compare_with(program, tmp_path):
    rng = np.random.default_rng(0)
    for i in range(8):
        save(PointCloud(rng.normal(size=(99, 3))), tmp_path / f"c{i}.xyz")
    arguments = ("collection=folder", f"collection.path={tmp_path}", "basis.k=5", "latent.size=4", "latent.keep=3")
    with pytest.raises(InputError, match="c.: expected a mesh to compare with, it has no faces"):
        program(tmp_path / "out", "task=reconstruction", *arguments)


def test_shapes_far_from_zero_are_refused(program, deformed_spheres, tmp_path):
    """As float32, which is what nets draw in, they would have no digits left."""
    for i, mesh in enumerate(deformed_spheres(8, 1)):
        save(Mesh(mesh.vertices + [4e6, 0, 5e6], mesh.faces), tmp_path / f"s{i}.off")
    arguments = ("collection=folder", f"collection.path={tmp_path}", "basis.k=5", "latent.size=4", "latent.keep=3")
    for net in ("reconstructor", "vertices"):
        with pytest.raises(InputError, match="expected shapes near the origin, got s0 far from it"):
            program(tmp_path / "out", "task=reconstruction", f"net={net}", *arguments)
    assert not (tmp_path / "out" / "last.ckpt").exists()


def test_the_nearest_pose_of_a_training_shape_is_its_own(body_meshes):
    clouds = np.stack([sample(mesh, 512, np.random.default_rng(i)) for i, mesh in enumerate(body_meshes[:16])])
    nearest = NearestPose(clouds, [str(i) for i in range(16)])
    assert [nearest(mesh) for mesh in body_meshes[:16]] == [str(i) for i in range(16)]
    assert nearest(PointCloud(clouds[5])) == "5"


def test_means_of_the_columns_that_all_have():
    assert means([{"cd": 1, "x": 2}, {"cd": 3}]) == {"cd": 2}
