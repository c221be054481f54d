import numpy as np
import pytest
from PIL import Image
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.plugins.custom_scalar.layout_pb2 import Layout
from tensorboard.util.tensor_util import make_ndarray

from lssd_learn.shapes import PointCloud
from lssd_learn.view.board import write_board, write_command

N, M = 6, 5
RNG = np.random.default_rng(0)
PAGE = {
    "operators": np.eye(M) + 0.1 * RNG.normal(size=(N, M, M)),
    "names": [f"shape_{i}" for i in range(N)],
    "columns": {"side": list("ababab")},
    "spectrum": np.arange(M, dtype=float),
    "shape_spectra": np.arange(M) + RNG.uniform(-0.5, 0.5, (N, M)),
    "points": RNG.normal(size=(N, 4)),
    "ratios": np.array([0.5, 0.3, 0.1, 0.1]),
    "labels": list("ababab"),
    "shapes": [PointCloud(RNG.normal(size=(9, 3))) for _ in range(N)],
    "up": "z",
}


@pytest.fixture
def page(tmp_path):
    """A function that writes the page, with changes, and reads the events."""

    def write(**changes):
        write_board(tmp_path / "tensorboard", **(PAGE | changes))
        events = EventAccumulator(str(tmp_path / "tensorboard"))
        events.Reload()
        return events

    return write


def test_a_page_holds_pictures_shapes_and_the_projector(page, tmp_path):
    events = page()
    assert set(events.Tags()["images"]) == {
        "latent/spectrum", "latent/collection", "operators/mean", "operators/minus_mean",
    }  # fmt: skip
    assert make_ndarray(events.Tensors("shapes/first_VERTEX")[0].tensor_proto).shape == (1, 4 * 9, 3)
    assert events.Tags()["scalars"] == []  # HPARAMS would list them as scores of a training run
    labels = (tmp_path / "tensorboard" / "labels.tsv").read_text().splitlines()
    assert labels[:2] == ["name\tside", "shape_0\ta"]


def test_the_text_says_who_stands_where_and_what_command_it_was(page, tmp_path):
    write_command(tmp_path / "tensorboard", "lssd net=mlp")
    write_command(tmp_path / "tensorboard", "lssd net=cnn")
    events = page()
    told = {tag: [make_ndarray(event.tensor_proto).item().decode() for event in events.Tensors(f"{tag}/text_summary")]
            for tag in ("command", "shapes/first")}  # fmt: skip
    assert told == {"command": ["    lssd net=cnn"],
                    "shapes/first": ["From left to right: shape_0, shape_1, shape_2, shape_3."]}  # fmt: skip


def test_letters_are_large_enough_for_a_card(page):
    """Drawn for a card of 300 pixels: not wider than twice that."""
    events = page()
    for tag in events.Tags()["images"]:
        assert events.Images(tag)[0].width <= 600


def test_the_spectrum_as_curves_has_a_chart_with_the_range_of_the_shapes(page):
    events = page(curves=True)
    for tag, expected in (
        ("latent", PAGE["spectrum"]),
        ("lowest", PAGE["shape_spectra"].min(0)),
        ("highest", PAGE["shape_spectra"].max(0)),
    ):
        scalars = events.Scalars(f"spectrum/{tag}")
        assert [scalar.step for scalar in scalars] == list(range(M))
        np.testing.assert_allclose([scalar.value for scalar in scalars], expected, rtol=1e-6)
    layout = Layout.FromString(make_ndarray(events.Tensors("custom_scalars__config__")[0].tensor_proto).item())
    (series,) = layout.category[0].chart[0].margin.series
    assert {series.value, series.lower, series.upper} == set(events.Tags()["scalars"])


def test_a_page_written_again_replaces_the_first(page):
    page()
    events = page(shapes=[PointCloud(np.eye(3))])
    assert len(events.Images("operators/mean")) == 1
    (only,) = events.Tensors("shapes/first_VERTEX")
    assert make_ndarray(only.tensor_proto).shape == (1, 3, 3)


def test_an_operator_stands_beside_its_colour_bar(page, tmp_path):
    """The mean of identities is yellow on violet; the bar beside it runs through the greens between."""
    image = page(operators=np.stack([np.eye(M)] * N)).Images("operators/mean")[0]
    (tmp_path / "mean.png").write_bytes(image.encoded_image_string)
    pixels = np.asarray(Image.open(tmp_path / "mean.png").convert("RGB")).reshape(-1, 3).astype(int)
    green = (np.abs(pixels - [33, 145, 140]).max(1) < 8).sum()  # viridis at one half
    assert green > 20
