"""`task=predict` by a net that reads points."""

import csv

import numpy as np
import torch

from lssd_learn.collections import Bodies
from lssd_learn.shapes import Mesh, PointCloud, save
from lssd_learn.shapes.writing import own_origin

BODIES = ("collection=bodies_small", "collection.n=40")
SMALL = ("basis.k=40", "latent.size=24", "latent.keep=20")


def test_a_net_on_clouds_reads_clouds_of_as_many_points(program, tmp_path):
    out = tmp_path / "trained"
    program(out, *BODIES, *SMALL, "net=pointnet", "net.variant=A", "data.points=64", "task.epochs=1")
    metrics = program(
        tmp_path, "task=predict", f"ckpt_path={out / 'best.ckpt'}", *BODIES, "collection.seed=1", "data.points=9"
    )
    assert set(metrics) == {"shapes", "trusted", "test/mse", "test/l1"}
    points = np.random.default_rng(0).normal(size=(99, 3))
    (tmp_path / "scans").mkdir()
    save(PointCloud(points), tmp_path / "scans" / "scan.xyz")
    arguments = ("collection=folder", f"collection.path={tmp_path / 'scans'}")
    found = program(tmp_path, "task=predict", f"ckpt_path={out / 'best.ckpt'}", *arguments)
    assert found == {"shapes": 1, "trusted": 0}  # nothing of the size of a body


def test_a_net_on_clouds_far_from_zero_is_that_on_shapes_moved_near(program, tmp_path):
    """Geocentric coordinates, of which float32 would leave a few points; the checkpoint keeps what is taken off."""
    bodies = Bodies(n=12, topology="notoes_collapse5pc")
    far = np.array([3.9e6, 1.1e6, 4.9e6])
    origin = own_origin(Mesh(bodies[0].vertices + far, bodies[0].faces))
    found = []
    for place, shift in (("far", far), ("near", far - origin)):
        folder = tmp_path / place
        folder.mkdir()
        for name, body in zip(bodies.names, bodies, strict=True):
            save(Mesh(body.vertices + shift, body.faces), folder / f"{name}.off")
        rows = [f"{name},{height}" for name, height in zip(bodies.names, bodies.parameters[:, 0], strict=True)]
        (folder / "labels.csv").write_text("\n".join(["name,height", *rows]))
        where = ("collection=folder", f"collection.path={folder}", "basis.k=20", "latent.size=10", "latent.keep=8")
        out = tmp_path / f"run_{place}"
        program(out, *where, "net=pointnet", "net.variant=A", "data.points=64", "task.epochs=3")
        program(tmp_path / f"new_{place}", "task=predict", f"ckpt_path={out / 'best.ckpt'}", *where[:2])
        with (tmp_path / f"new_{place}" / "predictions.csv").open(newline="") as stream:
            found.append([float(row["height"]) for row in csv.DictReader(stream)])
        kept = torch.load(out / "best.ckpt", weights_only=True)["origin"].numpy()
        np.testing.assert_array_equal(kept, origin if place == "far" else 0)
    assert np.ptp(found[0]) > 1e-3
    np.testing.assert_allclose(*found, atol=1e-4)
