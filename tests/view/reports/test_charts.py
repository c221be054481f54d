import re
from xml.etree import ElementTree

import numpy as np
import pytest

from lssd_learn.view.reports.charts import confusion, grid, histogram, scatter

SVG = "{http://www.w3.org/2000/svg}"


def drawing(figure):
    return ElementTree.fromstring(re.search(r"<svg.*</svg>", figure, re.DOTALL)[0])


def test_points_lie_in_their_hulls_within_the_frame():
    points = np.random.default_rng(0).normal(size=(40, 2))
    labels = ["a"] * 20 + ["b"] * 18 + ["c", None]
    figure = scatter(points, [f"<{i}>" for i in range(40)], labels, ("x", "y"), "a < b", ["data:,"] * 4)
    svg = drawing(figure)
    circles = svg.findall(f"{SVG}circle")
    places = np.array([[float(c.get("cx")), float(c.get("cy"))] for c in circles])
    assert {c.find(f"{SVG}title").text for c in circles} >= {"<0>: a", "<38>: c", "<39>"}
    width, height = map(float, svg.get("viewBox").split()[2:])
    assert (places > 0).all()
    assert (places < [width, height]).all()
    names = [c.find(f"{SVG}title").text for c in circles]
    seen = places[[names.index(f"<{i}>: a") for i in range(20)]]
    assert np.corrcoef(seen[:, 0], points[:20, 0])[0, 1] > 0.9999
    assert np.corrcoef(seen[:, 1], points[:20, 1])[0, 1] < -0.9999
    hulls = svg.findall(f"{SVG}polygon")
    assert len(hulls) == 2  # a single shape has none, nor have those without a label
    corners = np.array([[float(v) for v in pair.split(",")] for pair in hulls[0].get("points").split()])
    assert {tuple(c) for c in corners} <= {tuple(p) for p in seen}
    assert len(svg.findall(f"{SVG}image")) == 4
    assert figure.count("<span>") == 4


def test_points_on_a_line_have_no_hull():
    figure = scatter(np.zeros((4, 2)), list("abcd"), ["a"] * 4, ("x", "y"), "t")
    assert not drawing(figure).findall(f"{SVG}polygon")


def test_a_histogram_counts_everything_and_marks_the_data():
    found = np.concatenate([[5.0], np.linspace(0, 4, 99)])
    svg = drawing(histogram(found, "F", "F", "p = .01"))
    counts = [int(bar.find(f"{SVG}title").text.split()[0]) for bar in svg.findall(f"{SVG}rect")]
    assert sum(counts) == 100
    marks = [line for line in svg.findall(f"{SVG}line") if line.get("stroke-width") == "2"]
    bars = [float(bar.get("x")) + float(bar.get("width")) for bar in svg.findall(f"{SVG}rect")]
    assert float(marks[0].get("x1")) == pytest.approx(max(bars), abs=1.2)
    assert not drawing(histogram(np.ones(5), "F", "F", "p = 1")).findall(f"{SVG}nothing")


def test_a_confusion_has_its_counts():
    text = grid([confusion(np.array([[9, 1], [2, 8]]), ["<a>", "b"], "told")])
    assert re.findall(r">(\d+)</td>", text) == ["9", "1", "2", "8"]
    assert text.count("&lt;a&gt;") == 2
