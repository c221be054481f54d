import numpy as np
import pytest
from google.protobuf import text_format
from tensorboard.plugins.projector import ProjectorConfig

from lssd_learn.view.projector import write_projector

POINTS = np.random.default_rng(0).normal(size=(3, 4))


def read(folder):
    """Points and rows of labels, found as TensorBoard finds them."""
    config = text_format.Parse((folder / "projector_config.pbtxt").read_text(), ProjectorConfig())
    (embedding,) = config.embeddings
    labels = (folder / embedding.metadata_path).read_text().splitlines()
    return np.loadtxt(folder / embedding.tensor_path, delimiter="\t", ndmin=2), [row.split("\t") for row in labels]


def test_points_and_labels_are_read_back(tmp_path):
    columns = {"name": ["a", "b", "c"], "pose": np.array(["x", "y", "x"]), "height": np.array([1, 2 / 3, 1e-9])}
    write_projector(tmp_path, POINTS, columns)
    points, labels = read(tmp_path)
    np.testing.assert_allclose(points, POINTS, rtol=1e-4)
    assert labels == [
        ["name", "pose", "height"],
        ["a", "x", "1"],
        ["b", "y", "0.6667"],
        ["c", "x", "1e-09"],
    ]


def test_names_alone_have_no_title(tmp_path):
    """TensorBoard takes the first line for titles where it holds a tab, and only there."""
    write_projector(tmp_path, POINTS, {"name": ["a\tb", "c\nd", "é"]})
    assert read(tmp_path)[1] == [["a b"], ["c d"], ["é"]]


def test_a_second_time_replaces_the_first(tmp_path, capsys):
    write_projector(tmp_path, POINTS, {"name": ["a", "b", "c"]})
    write_projector(tmp_path, POINTS[:2] + 1, {"name": ["d", "e"]})
    points, labels = read(tmp_path)
    np.testing.assert_allclose(points, POINTS[:2] + 1, rtol=1e-4)
    assert labels == [["d"], ["e"]]
    assert capsys.readouterr().out == ""


def test_a_column_that_does_not_fit_is_an_error(tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        write_projector(tmp_path, POINTS, {"name": ["a", "b", "c"], "pose": ["x", "y"]})
