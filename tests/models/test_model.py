"""A trained model in a notebook: loaded from its file, asked of shapes in any form."""

import shutil

import numpy as np
import pytest
import torch

from lssd_learn import models
from lssd_learn.cache import Cache
from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.nets import CNN
from lssd_learn.shapes import Mesh, save

BODIES = ("collection=bodies_small", "collection.n=40")
SIZES = ("basis.k=40", "latent.size=32", "latent.keep=24", "latent.operators=[area,conformal]")


class Mine(CNN):
    """A net of somebody's own."""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("model")


@pytest.fixture(scope="module")
def program(pieces_of, home, common_cache):
    """A function (name, overrides) → the folder of a run, on one cache."""

    def run(name, *overrides):
        pieces = pieces_of(home / name, *BODIES, *overrides, f"cache={common_cache}")
        pieces.task(pieces, home / name)
        return home / name

    return run


@pytest.fixture(scope="module")
def load(common_cache):
    return lambda folder: models.load(folder / "best.ckpt", Cache(common_cache))


@pytest.fixture(scope="module")
def regression(program):
    return program("regression", *SIZES, "task.epochs=2")


@pytest.fixture
def new():
    bodies = Bodies(n=3, seed=1, topology="notoes_collapse5pc")
    return list(bodies)


@pytest.fixture(autouse=True)
def _cache(common_cache, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(common_cache))


def test_it_says_what_task_predict_writes(program, regression, load, new):
    model = load(regression)
    out = program("predict", "task=predict", f"ckpt_path={regression / 'best.ckpt'}", "collection.seed=1")
    written = np.genfromtxt(out / "predictions.csv", delimiter=",", skip_header=1)[:3, 1 : 1 + len(model.parameters)]
    np.testing.assert_allclose(model.predict(new), written, atol=1e-4)
    assert model.parameters == Bodies(n=1).parameter_names
    assert (model.task, len(model.latent), model.collection.names[39]) == ("regression", 40, "body_0039")


def test_shapes_come_in_any_form(regression, load, new, tmp_path):
    model = load(regression)
    expected = model.predict(new)
    save(new[2], tmp_path / "c.off")
    given = [(new[0].vertices, new[0].faces), new[1], str(tmp_path / "c.off")]
    np.testing.assert_allclose(model.predict(given), expected, atol=1e-6)
    np.testing.assert_allclose(model.predict(tmp_path), expected[2:], atol=1e-6)


def test_strangers_are_mapped(regression, load, new):
    model = load(regression)
    order = np.random.default_rng(0).permutation(615)
    stranger = Mesh(new[0].vertices[order], np.argsort(order)[new[0].faces])
    found = model.predict([new[0], stranger], maps="registration", candidates=5)
    assert found.shape == (2, 12)
    assert np.isfinite(found).all()
    with pytest.raises(InputError, match="1: expected a mesh in vertex correspondence"):
        model.predict([new[0], stranger], maps="correspondence")


def test_a_classification_gives_labels_and_how_sure_it_is(program, load, new):
    model = load(program("classification", *SIZES, "task=classification", "net=kernel"))
    chances = model.probabilities(new)
    np.testing.assert_allclose(chances.sum(1), 1)
    assert model.predict(new).tolist() == [model.classes[i] for i in chances.argmax(1)]
    assert repr(model) == "Trained(classification of pose: 8 classes, KernelMachine on area+conformal operators)"
    with pytest.raises(InputError, match="reconstruct: expected a reconstruction, this is a classification"):
        model.reconstruct(new)


def test_a_reconstruction_draws_and_predicts_nothing(program, load, new):
    model = load(program("reconstruction", *SIZES, "task=reconstruction", "net=vertices", "task.points=50"))
    drawn = model.reconstruct(new)
    assert [len(mesh.vertices) for mesh in drawn] == [615] * 3
    assert drawn[0].connectivity == new[0].connectivity
    error = np.linalg.norm(drawn[0].vertices - new[0].vertices, axis=1).mean()
    assert error < np.linalg.norm(drawn[0].vertices - new[1].vertices, axis=1).mean()
    with pytest.raises(InputError, match="predict: expected a regression or a classification"):
        model.predict(new)


def test_a_net_on_clouds_needs_no_space(program, load, new):
    model = load(program("clouds", *SIZES, "net=pointnet", "net.variant=A", "data.points=64", "task.epochs=1"))
    assert model.predict(new).shape == (3, 12)
    assert (model.latent, model.collection) == (None, None)
    assert repr(model) == "Trained(regression of 12 parameters, PointNet on clouds of 64)"


def test_the_net_of_somebody_else_has_to_be_a_plug_in_or_given(regression, home):
    content = torch.load(regression / "best.ckpt", weights_only=True)
    torch.save(content | {"net": ["somewhere.Else", {}]}, home / "other.ckpt")
    with pytest.raises(InputError, match="other.ckpt: its net is somewhere.Else, but somewhere is no plug-in of"):
        models.load(home / "other.ckpt")
    torch.save(content | {"net": [f"{__name__}.Mine", content["net"][-1]]}, home / "other.ckpt")
    assert type(models.load(home / "other.ckpt", net=Mine).learner.net) is Mine


def test_no_checkpoint_is_told(home, regression):
    shutil.copy(regression / "last.ckpt", home / "last.ckpt")
    for name, message in (("none.ckpt", "no such file"), ("last.ckpt", "expected the best.ckpt of task=regression or")):
        with pytest.raises(InputError, match=message):
            models.load(home / name)
