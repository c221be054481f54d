from types import SimpleNamespace

import numpy as np
import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.util.tensor_util import make_ndarray

from lssd_learn.collections import ShapeList
from lssd_learn.pipeline import Pipeline
from lssd_learn.tasks import overview as overview_module
from lssd_learn.tasks.overview import write_overview


@pytest.fixture
def overview(cache, tmp_path):
    """A function that writes the page of a collection; gives the events and the rows of labels.tsv."""

    def write(collection, **options):
        pipeline = Pipeline(collection, k=12, size=10, keep=8, cache=cache)
        write_overview(SimpleNamespace(pipeline=pipeline, operators=["area"]), tmp_path, **options)
        events = EventAccumulator(str(tmp_path / "tensorboard"))
        events.Reload()
        return events, [row.split("\t") for row in (tmp_path / "tensorboard/labels.tsv").read_text().splitlines()]

    return write


def scene(events, kind):
    return make_ndarray(events.Tensors(f"shapes/first_{kind}")[0].tensor_proto)


def test_a_plain_list_of_shapes_is_shown(overview, meshes, tmp_path):
    events, labels = overview(meshes)
    assert labels == [[str(i)] for i in range(6)]
    assert np.loadtxt(tmp_path / "tensorboard/operators.tsv").shape == (6, 5)
    assert scene(events, "VERTEX").shape == (1, 4 * 162, 3)
    assert scene(events, "FACE").max() == 4 * 162 - 1


def test_groups_and_parameters_label_the_projector(overview, spheres):
    collection = spheres()
    collection.parameters, collection.parameter_names = np.arange(12).reshape(6, 2) / 7, ["width", "age"]
    _, labels = overview(collection)
    assert labels[0] == ["name", "half", "parity", "width", "age"]
    assert labels[4] == ["3", "b", "1", "0.8571", "1"]


def test_the_projector_keeps_distances_between_operators(overview, meshes, cache, tmp_path):
    overview(meshes)
    points = np.loadtxt(tmp_path / "tensorboard/operators.tsv")
    operators = Pipeline(meshes, k=12, size=10, keep=8, cache=cache).operators().numpy().reshape(6, -1)
    distances = (np.linalg.norm(x[:, None] - x, axis=-1) for x in (points, operators))
    np.testing.assert_allclose(*distances, atol=1e-3 * np.ptp(points))


def test_clouds_that_a_net_reads_are_shown_in_place_of_the_shapes(overview, meshes):
    clouds = np.random.default_rng(0).normal(size=(6, 20, 3))
    events, _ = overview(meshes, clouds=clouds)
    assert scene(events, "VERTEX").shape == (1, 4 * 20, 3)
    assert "shapes/first_FACE" not in events.Tags()["tensors"]


def test_two_shapes_are_enough(overview, meshes):
    assert overview(ShapeList(meshes[:2]), pictures=True)[1] == [["0"], ["1"]]


def test_of_many_shapes_some_are_shown(overview, spheres, monkeypatch, tmp_path):
    monkeypatch.setattr(overview_module, "MOST", 3)
    _, labels = overview(spheres())
    assert [row[0] for row in labels[1:]] == ["0", "2", "4"]
    assert len(np.loadtxt(tmp_path / "tensorboard/operators.tsv")) == 3
