import base64
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
import trimesh
from PIL import Image

from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.view.fields import Field
from lssd_learn.view.reports import stage
from lssd_learn.view.reports.blocks import paragraph, table
from lssd_learn.view.reports.charts import scatter
from lssd_learn.view.reports.page import Section, write_page
from lssd_learn.view.reports.stage import Stage, Way

BALL = trimesh.creation.icosphere(3)
SHAPES = [Mesh(BALL.vertices + [0, 0, 5], BALL.faces), PointCloud(2 * BALL.vertices)]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
STAGE = {
    "shapes": SHAPES,
    "names": ["</script><script>alert(1)</script>", "cloud"],
    "groups": ["<a>", "b"],
    "fields": [
        Field.squared("top", "top", [np.maximum(BALL.vertices[:, 2:], 0)] * 2),
        Field.signed("side", "side", [BALL.vertices[:, 0]] * 2),
    ],
    "up": "z",
    "azimuth": 20.0,
    "picture": b"png",
    "hint": "two <shapes>",
}
POINTS = np.array([[0, 1e-7], [1, 2e-7], [2, 0], [1, 0]])
SECTIONS = [
    Section("Numbers <1>", [table(["", "area"], [["p < 1", "0.01"]]), paragraph("Where α² is large.", "note")]),
    Section("Embeddings", [scatter(POINTS, list("wxyz"), ["<a>", "b", None, "b"], ("first", "second"), "before")]),
]
TEXTS = {"title": "kind: <a> against b", "summary": "4 shapes", "sections": SECTIONS, "footer": "made by a test"}


@pytest.fixture
def page(tmp_path):
    """A function that writes the page, with changes, and gives its text and what the script reads."""

    def write(**changes):
        write_page(tmp_path / "report.html", stage=Stage(**(STAGE | changes)), **TEXTS)
        text = (tmp_path / "report.html").read_text(encoding="utf-8")
        return text, json.loads(re.search(r'<script type="application/json" id="data">(.*)</script>', text)[1])

    return write


def decode(text, dtype):
    return np.frombuffer(base64.b64decode(text), dtype)


def test_shapes_stand_upright_around_zero_with_a_byte_a_value(page):
    _, data = page()
    ball, cloud = data["shapes"]
    points = decode(ball["points"], "<f4").reshape(-1, 3)
    np.testing.assert_allclose(points, BALL.vertices[:, [0, 2, 1]] * [1, 1, -1], atol=1e-6)
    np.testing.assert_array_equal(decode(ball["faces"], "<u4").reshape(-1, 3), BALL.faces)
    assert cloud["faces"] is None
    top, side = (decode(values, np.uint8).astype(int) for values in ball["values"])
    assert (top[points[:, 1] < 0] == 0).all()
    assert top[points[:, 1].argmax()] == 255
    assert side[np.abs(points[:, 0]) < 1e-6] == pytest.approx(128, abs=1)
    assert (data["extent"], data["radius"], data["upright"]) == ([pytest.approx(4, rel=0.01)] * 2, 2, True)
    assert len(decode(data["colormaps"]["OrRd"], np.uint8)) == 3 * 256
    assert [field["low"] for field in data["fields"]] == ["0", data["fields"][1]["low"]]


def test_nothing_comes_from_elsewhere_and_texts_stay_texts(page):
    text, data = page()
    addresses = set(re.findall(r"https?://[^\s\"'<]+", text))
    assert addresses == {"http://www.w3.org/2000/svg"}  # a name, not a place
    assert "default-src 'none'" in text
    assert "<script>alert" not in text
    assert data["shapes"][0]["name"] == STAGE["names"][0]
    assert "<title>kind: &lt;a&gt; against b</title>" in text
    assert "<th>p &lt; 1</th><td>0.01</td>" in text
    assert "<h2>Numbers &lt;1&gt;</h2>" in text
    assert "two &lt;shapes&gt;" in text
    assert re.findall(r"<title>(.*?)</title></circle>", text) == ["y", "w: &lt;a&gt;", "x: b", "z: b"]  # grey below


def test_shapes_of_unknown_up_stay_as_they_are_and_may_turn_any_way(page):
    _, data = page(up=None)
    np.testing.assert_allclose(decode(data["shapes"][1]["points"], "<f4").reshape(-1, 3), 2 * BALL.vertices, atol=1e-6)
    assert not data["upright"]


def test_a_page_stays_small(page, monkeypatch):
    monkeypatch.setattr(stage, "MOST", 400)
    _, data = page()
    for shape in data["shapes"]:
        count = len(decode(shape["points"], "<f4")) // 3
        assert count <= 200
        assert {len(decode(values, np.uint8)) for values in shape["values"]} == {count}


def test_a_way_is_there_to_a_part_of_its_extent_and_all_of_it_is_in_the_picture(page):
    middle, step = BALL.vertices + [0, 0, 5], 3 * BALL.vertices * [0, 0, 1]
    way = Way("tall", ("flat", "tall"), middle, step, (0.0, 2.0), 1)
    _, data = page(ways=[way])
    seen = data["shapes"][0]["ways"][0]
    assert (seen["title"], seen["ends"], seen["at"], seen["field"]) == ("tall", ["flat", "tall"], [0, 2], 1)

    def unpacked(packed):
        return packed["low"] + packed["scale"] * decode(packed["codes"], "<u2").reshape(-1, 3)

    np.testing.assert_allclose(unpacked(seen["step"]), step[:, [0, 2, 1]] * [1, 1, -1], atol=1e-4)
    np.testing.assert_allclose(unpacked(seen["middle"]), BALL.vertices[:, [0, 2, 1]] * [1, 1, -1], atol=1e-4)
    assert data["shapes"][1]["ways"] == []
    assert data["extent"][1] == pytest.approx(8, rel=0.01)  # stretched four times
    assert data["radius"] == pytest.approx(4, rel=0.01)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_a_browser_shows_it(page, tmp_path):
    page(picture=b"")
    picture = tmp_path / "page.png"
    options = [
        "--headless",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--virtual-time-budget=3000",
        "--window-size=900,700",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    line = [CHROMIUM, *options, f"--screenshot={picture}", (tmp_path / "report.html").as_uri()]
    subprocess.run(line, check=True, capture_output=True, timeout=60)
    seen = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    red = (seen[..., 0] > 100) & (seen[..., 1] < 60) & (seen[..., 2] < 60)
    rows, columns = np.nonzero(red)
    halves = columns < 450  # a mesh on the left, a cloud on the right
    assert halves.sum() > 200
    assert (~halves).sum() > 200

    # A ruler and the axes of the files lie over the shapes; a view in the address is taken, here upside down and near.
    view = "#view=-1,0,0,0,-1,0,0,0,1,8,0,0,0"
    line = [CHROMIUM, *options, "--dump-dom", (tmp_path / "report.html").as_uri() + view]
    dom = subprocess.run(line, check=True, capture_output=True, text=True, timeout=60).stdout
    drawn = re.search(r'<svg id="marks".*?</svg>', dom, re.S)[0]
    words = dict(reversed(pair) for pair in re.findall(r'y="([-\d.]+)"[^>]*>([\w.]+)</text>', drawn))
    assert {"x", "y", "z"} < set(words)
    assert float(words["z"]) > float(words["x"])  # up in the file is down on the screen
    (length,) = (float(word) for word in set(words) - {"x", "y", "z"})
    assert 0 < length <= 0.5
