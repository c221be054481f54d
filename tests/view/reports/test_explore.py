"""The page that a person moves through, in a browser without a network."""

import numpy as np
import pytest
import torch
import trimesh
from browser import CHROMIUM, Browser

from lssd_learn.exploration.modes import shape_map
from lssd_learn.shapes import Mesh
from lssd_learn.view.reports.explore import write_explorer

BALL = trimesh.creation.icosphere(2)
NAMES = ["</script><script>alert(1)</script>", *(f"shape {i}" for i in range(1, 12))]


@pytest.fixture(scope="module")
def moves():
    """Twelve balls that grow along two axes and bend."""
    numbers = np.random.default_rng(0).uniform(-0.4, 0.4, (12, 2))
    x = BALL.vertices
    ways = np.stack([x * [1, 0, 0], x * [0, 0, 1], x[:, :1] ** 2 * [0, 0, 1]])
    vertices = x + np.tensordot(np.column_stack([numbers, np.sin(4 * numbers[:, 0])]), ways, 1)
    return shape_map(torch.tensor(numbers), vertices)


@pytest.fixture(scope="module")
def page(moves, tmp_path_factory):
    path = tmp_path_factory.mktemp("explore") / "explore.html"
    mean = Mesh(moves.mean, BALL.faces)
    texts = {"title": "Balls", "summary": "a < b", "footer": "made by a test"}
    write_explorer(path, mean=mean, moves=moves, names=NAMES, up="z", azimuth=20, **texts)
    return path


@pytest.fixture(scope="module")
def browser(page, tmp_path_factory):
    if CHROMIUM is None:
        pytest.skip("no Chromium here")
    browser = Browser(page, tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()
    assert browser.errors == []


def test_what_names_hold_is_no_markup(page):
    text = page.read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "a &lt; b" in text
    assert "http" not in text.replace("http-equiv", "")


def points(browser):
    return np.array(browser.ask("Array.from(mesh.points)")).reshape(-1, 3)


def upright(moves, c):
    """The vertices of coordinates as the page has them, but for where their middle is."""
    return turned(moves.vertices(np.asarray(c)[None])[0])


def turned(x):
    return np.stack([x[:, 0], x[:, 2], -x[:, 1]], axis=1)


def test_a_drag_changes_the_shape_and_its_picture(browser, moves, tmp_path):
    browser.frames(3)
    before, seen = points(browser), browser.picture(tmp_path / "before.png").read_bytes()
    browser.drag(browser.middle("#component-1"), browser.middle("#component-1", 0.9))
    after, value = points(browser), float(browser.ask("at('component-1').value"))
    assert value > 1
    c = np.zeros(moves.coordinates.shape[1])
    c[0] = value * np.sqrt(np.mean(moves.coordinates[:, 0] ** 2))
    np.testing.assert_allclose(after - before, upright(moves, c) - upright(moves, 0 * c), atol=2e-3)
    assert np.abs(after - before).max() > 0.1
    assert browser.picture(tmp_path / "after.png").read_bytes() != seen


def test_keys_and_fingers(browser):
    browser.ask("at('component-2').focus()")
    before = points(browser)
    browser.key("ArrowRight")
    by_key = points(browser)
    assert np.abs(by_key - before).max() > 1e-4
    browser.touch(browser.middle("#component-2"), browser.middle("#component-2", 0.1))
    assert float(browser.ask("at('component-2').value")) < -1
    assert np.abs(points(browser) - by_key).max() > 0.05


def test_ways_and_analogies(browser, moves):
    browser.ask("at('tab-between').click()")
    assert browser.ask("[at('components').hidden, at('between').hidden]") == [True, False]
    browser.ask("at('p').selectedIndex = 3; at('q').selectedIndex = 7; at('u').value = 0.25; show()")
    c = moves.coordinates
    mean = np.array(browser.ask("Array.from(mesh.mean)")).reshape(-1, 3)
    expected = upright(moves, 0.75 * c[3] + 0.25 * c[7]) - turned(moves.mean)
    np.testing.assert_allclose(points(browser) - mean, expected, atol=2e-3)
    browser.ask("at('tab-analogy').click()")
    browser.ask("at('a').selectedIndex = 1; at('b').selectedIndex = 1; at('c').selectedIndex = 4; show()")
    np.testing.assert_allclose(points(browser) - mean, upright(moves, c[4]) - turned(moves.mean), atol=2e-3)
