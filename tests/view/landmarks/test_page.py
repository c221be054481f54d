"""The page of carried landmarks: what is doubtful first, marked, and nothing that a name could smuggle in."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bumps
from lssd_learn.shapes import Mesh
from lssd_learn.view.landmarks.charts import benchmark_chart
from lssd_learn.view.landmarks.page import ALIKE, Sheet, write_landmark_page
from lssd_learn.view.landmarks.pictures import close_up, turned_like, view_of

SHAPES = [*Bumps(subdivisions=2)]
VERTICES = [0, 50, 120]


def sheet(bars, **more):
    points = np.array([shape.vertices[VERTICES] for shape in SHAPES])
    carried = np.array([[i > 1] * 3 for i in range(4)])
    names = ["hub", "<b>hub", "first", "second"]
    return Sheet(
        SHAPES, names, ["tip", "<i>", "side"], points, np.where(carried, bars, np.nan), carried, [0, 1], **more
    )


def test_the_most_doubtful_comes_first_and_is_marked(tmp_path):
    bars = np.array([[0, 0, 0], [0, 0, 0], [0.1, 0.3, 0.2], [0.15, 0.9, 0.05]])
    page = tmp_path / "page.html"
    found = sheet(bars, lost=["gone"], slips=["tip of hub"])
    assert found.doubtful == [(3, 1), (2, 1), (2, 2), (3, 0), (2, 0)]
    write_landmark_page(page, found)
    text = page.read_text()
    titles = re.findall(r"<h3>(.*?) <small>± (.*?)</small>", text)
    assert titles[:2] == [("&lt;i&gt; of second", "0.9"), ("&lt;i&gt; of first", "0.3")]
    index = re.search(r'<p class="index">(.*)</p>', text)[1]
    assert re.findall(r'<a href="#(check-\d-\d)">', index) == re.findall(r'class="card" id="(.*?)"', text)
    assert index.startswith('<a href="#check-3-1">&lt;i&gt; of second</a> · <a')
    assert "6 landmarks carried to 2 shapes from 2." in text
    assert "got none: gone" in text
    assert "where the others say them: tip of hub" in text
    assert text.count('<td class="check">') == 5
    assert "<i>" not in text
    assert "<b>hub" not in text
    assert "://" not in text  # nothing is fetched
    pictures = re.findall(r"data:image/png;base64,([^\"]+)", text)
    assert len(pictures) == 5 * 3 + 2 * 2
    image = np.asarray(Image.open(io.BytesIO(base64.b64decode(pictures[1]))).convert("RGB")).astype(int)
    assert ((image[..., 0] > 120) & (image[..., 2] < 90)).sum() > 30  # the red ball


def test_of_one_landmark_a_few_are_enough_and_without_bars_none_is_doubtful(tmp_path):
    many = sheet(np.ones((4, 3)))
    assert max(np.bincount([mark for _, mark in many.doubtful])) <= ALIKE
    nobody = sheet(np.full((4, 3), np.nan))
    assert nobody.doubtful == []
    write_landmark_page(tmp_path / "page.html", nobody)
    assert "There are no error bars" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_same_landmark_is_seen_alike_on_a_shape_that_lies_otherwise(mirrored):
    shape, points = SHAPES[3], SHAPES[3].vertices[VERTICES]
    motion = 2 * Rotation.random(rng=np.random.default_rng(0)).as_matrix() * ([-1, 1, 1] if mirrored else [1, 1, 1])
    other = Mesh(shape.vertices @ motion.T + 5, shape.faces[:, ::-1] if mirrored else shape.faces)
    view = view_of(shape, points[1])
    np.testing.assert_allclose(view @ view.T, np.eye(3), atol=1e-12)
    assert view[2] @ points[1] > 0  # seen from outside
    alike = turned_like(view, other, points @ motion.T + 5, shape, points)
    pictures = [close_up(shape, points, 1, view, 80), close_up(other, points @ motion.T + 5, 1, alike, 80)]
    assert np.abs(np.subtract(*[picture.astype(float) for picture in pictures])).mean() < 3
    assert pictures[0].std() > 10


def test_a_chart_of_errors_with_holes():
    errors = np.array([[0.1, 0.2], [0.3, np.nan]])
    figure = benchmark_chart(["a", "b"], errors, errors, {1: 0.3, 2: 0.2})
    assert len(figure.axes) == 3
