"""`data.twins`: training on operators as computed maps make them; `task=predict` for shapes in no correspondence."""

import csv

import numpy as np
import pytest
import torch

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.learning import split
from lssd_learn.models.trained import read_trained
from lssd_learn.twins import positions

BODIES = ("collection=bodies_small", "collection.n=40")
SMALL = (*BODIES, "basis.k=30", "latent.size=24", "latent.keep=12", "latent.operators=[area,conformal]", "net=kernel",
    "net.rounds=2", "maps=registration", "maps.rounds=3", "parallel.workers=1")  # fmt: skip
TWINS = ("data.twins=mesh", "data.twin_shapes=40", "data.twin_vertices=[400,500]")
STRANGERS = ("collection=remeshed", "collection.base.topology=notoes_collapse5pc", "collection.base.n=8",
    "collection.base.seed=1", "collection.vertices=[400,500]", "maps=registration", "maps.rounds=3")  # fmt: skip


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("twins")


@pytest.fixture(scope="module")
def program(pieces_of, home):
    """A function (out, overrides) → the metrics of a run of this process, on one cache."""

    def run(out, *overrides):
        pieces = pieces_of(out, *overrides, f"cache={home / 'cache'}", net="net")
        return pieces.task(pieces, out)

    return run


@pytest.fixture(scope="module")
def trained(home, program):
    """Metrics and checkpoint of a machine trained on bodies and twins."""
    return program(home / "trained", *SMALL, *TWINS), home / "trained" / "best.ckpt"


def test_a_machine_that_has_seen_twins_reads_strangers_better_than_the_mean(trained, program, tmp_path):
    metrics, path = trained
    assert 0 < metrics["validation/mse"] < metrics["reference/mean/mse"]
    found = program(tmp_path, *STRANGERS, "task=predict", f"ckpt_path={path}")
    assert found["shapes"] == 8
    strangers = Bodies(8, seed=1, topology="notoes_collapse5pc").parameters
    mean = np.mean((strangers - Bodies(40, topology="notoes_collapse5pc").parameters.mean(0)) ** 2)
    assert found["test/mse"] < mean
    with (tmp_path / "predictions.csv").open(newline="") as stream:
        assert len(list(csv.reader(stream))) == 9
    clouds = ("collection.kind=cloud", "collection.base.n=2")
    assert program(tmp_path, *STRANGERS, *clouds, "task=predict", f"ckpt_path={path}")["shapes"] == 2


def test_the_checkpoint_says_which_shapes_it_knows(trained):
    known = read_trained(trained[1], None).collection
    assert (len(known), known.topology, known.names[39]) == (40, "notoes_collapse5pc", "body_0039")


@pytest.mark.parametrize(
    ("described", "message"),
    [
        ({"_target_": "os.system"}, "os.system, but os is no plug-in of lssd_learn, and a file shall not name code to"),
        ({}, "nothing, but"),
        ({"_target_": "lssd_learn.collections.as_collection"}, ".*as_collection: expected one of lssd_learn.coll"),
        ({"_target_": "lssd_learn.cache.store.os.system"}, "lssd_learn.cache.store.os.system, which is not there"),
    ],
)
def test_a_checkpoint_names_no_code_of_others(trained, tmp_path, described, message):
    checkpoint = torch.load(trained[1], weights_only=True)
    torch.save(checkpoint | {"collection": described}, tmp_path / "other.ckpt")
    with pytest.raises(InputError, match=f"ckpt_path: the checkpoint names a collection {message}"):
        _ = read_trained(tmp_path / "other.ckpt", None).collection


def test_an_older_checkpoint_cannot_map_strangers(trained, program, tmp_path):
    checkpoint = torch.load(trained[1], weights_only=True)
    del checkpoint["collection"]
    torch.save(checkpoint, tmp_path / "old.ckpt")
    with pytest.raises(InputError, match="expected a checkpoint that says which shapes it was trained on"):
        program(tmp_path, *STRANGERS, "task=predict", f"ckpt_path={tmp_path / 'old.ckpt'}")
    plain = (*STRANGERS[:-2], "maps=correspondence")
    with pytest.raises(
        InputError, match=r"body_0000: expected a mesh in vertex correspondence .* or maps=kernel_match"
    ):
        program(tmp_path, *plain, "task=predict", f"ckpt_path={trained[1]}")


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("data.twins=scan",), "data.twins=scan: expected one of none, mesh, cloud"),
        (("data.twins=mesh", "maps=correspondence"), "data.twins=mesh: expected maps that are computed"),
        (("data.twins=mesh", "data.twin_shapes=1"), "data.twin_shapes=1: expected twins in train, test and validation"),
        (("data.twins=mesh", "data.twin_shapes=0"), "data.twin_shapes=0: expected a whole number"),
        (("data.twins=mesh", "data.protocol=inductive"), "expected data.protocol=transductive"),
        (
            ("data.twins=mesh", "net=pointnet", "task.epochs=1", "maps=registration"),
            "expected a net on operators; net=net reads clouds",
        ),
    ],
)
def test_twins_that_cannot_be(program, tmp_path, overrides, message):
    shared = [item for item in SMALL if not item.startswith(("net", "maps") if "net=pointnet" in overrides else "?")]
    if "maps=correspondence" in overrides:
        shared = [item for item in shared if not item.startswith("maps")]
    with pytest.raises(InputError, match=message):
        program(tmp_path, *shared, *overrides)


def test_twins_are_in_the_part_of_their_shapes():
    parts = split(40, 0)
    found = positions(parts, np.arange(40), 40)
    np.testing.assert_array_equal(found.test, 40 + parts.test)
    np.testing.assert_array_equal(found.validation, 40 + parts.validation)
    np.testing.assert_array_equal(found.train, np.concatenate([parts.train, 40 + parts.train]))
    chosen = np.sort([parts.train[0], parts.test[1], parts.validation[2]])
    few = positions(parts, chosen, 40)
    assert len(few.train) == len(parts.train) + 1
    assert chosen[few.test - 40].tolist() == [parts.test[1]]
    assert chosen[few.validation - 40].tolist() == [parts.validation[2]]
