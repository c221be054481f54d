"""What TensorBoard reads of a training run."""

import re

import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.plugins.custom_scalar.layout_pb2 import Layout
from tensorboard.plugins.hparams import metadata
from tensorboard.util.tensor_util import make_ndarray

from lssd_learn.learning.curves import Curves

CHOICES = {"net": "mlp", "seed": 0, "learning_rate": 0.01}


@pytest.fixture
def events(tmp_path):
    def read():
        accumulator = EventAccumulator(str(tmp_path))
        accumulator.Reload()
        return accumulator

    return read


def points(events, tag):
    return [(event.step, pytest.approx(event.value)) for event in events.Scalars(tag)]


def hparams(events, tag):
    return events.SummaryMetadata(tag).plugin_data.content


def test_a_run_is_listed_when_it_starts_and_closed_when_it_ends(tmp_path, events):
    curves = Curves(tmp_path)
    curves.start(CHOICES, ("mse", "l1"), {}, 5)
    curves.save()
    listed = metadata.parse_session_start_info_plugin_data(hparams(events(), metadata.SESSION_START_INFO_TAG))
    values = {name: value.string_value or value.number_value for name, value in listed.hparams.items()}
    assert values == CHOICES
    assert metadata.SESSION_END_INFO_TAG not in events().summary_metadata
    curves.finish({"test/mse": 0.5}, 5)
    assert points(events(), "test/mse") == [(5, 0.5)]
    ended = metadata.parse_session_end_info_plugin_data(hparams(events(), metadata.SESSION_END_INFO_TAG))
    assert ended.status == 1  # success
    # With an experiment's own summary TensorBoard shows the choices of the first run of a sweep alone.
    assert metadata.EXPERIMENT_TAG not in events().summary_metadata


def test_a_reference_is_a_level_line_of_the_first_score(tmp_path, events):
    curves = Curves(tmp_path)
    curves.start(CHOICES, ("mse", "l1"), {"ridge": 0.25}, 9)
    curves.finalize("success")
    assert points(events(), "test/mse/ridge") == [(1, 0.25), (9, 0.25)]


def test_every_score_has_one_chart_of_all_its_curves(tmp_path, events):
    curves = Curves(tmp_path)
    curves.start(CHOICES, ("mse", "l1"), {"ridge": 0.25}, 9)
    curves.finalize("success")
    layout = Layout.FromString(make_ndarray(events().Tensors("custom_scalars__config__")[0].tensor_proto).item())
    charts = {chart.title: chart.multiline.tag[0] for chart in layout.category[0].chart}
    tags = ["train/mse", "validation/mse", "test/mse", "test/mse/ridge", "train/l1", "test/mse500"]
    assert [tag for tag in tags if re.match(charts["mse"], tag)] == tags[:4]
    assert [tag for tag in tags if re.match(charts["l1"], tag)] == ["train/l1"]


def test_a_resumed_run_leaves_out_what_the_interrupted_one_wrote_too_much(tmp_path, events):
    first = Curves(tmp_path)
    for epoch in range(5):
        first.log_metrics({"train/mse": 1.0}, epoch + 1)
    first.finalize("failed")
    second = Curves(tmp_path, done=3)
    for epoch in range(3, 6):
        second.log_metrics({"train/mse": 2.0}, epoch + 1)
    second.finalize("success")
    assert points(events(), "train/mse") == [(1, 1), (2, 1), (3, 1), (4, 2), (5, 2), (6, 2)]
