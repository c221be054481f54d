import numpy as np
import pytest

from lssd_learn.view import raster
from lssd_learn.view.raster import rasterise


def rasterise_slowly(corners, height, width):
    """The same, pixel by pixel."""
    found = {}
    for row in range(height):
        for column in range(width):
            point = np.array([column + 0.5, row + 0.5])
            best = np.inf
            for i, triangle in enumerate(corners):
                edges = np.column_stack([triangle[1, :2] - triangle[0, :2], triangle[2, :2] - triangle[0, :2]])
                v, w = np.linalg.solve(edges, point - triangle[0, :2])
                depth = np.array([1 - v - w, v, w]) @ triangle[:, 2]
                if min(1 - v - w, v, w) >= 0 and depth < best:
                    best = depth
                    found[row * width + column] = (i, [1 - v - w, v, w])
    return found


@pytest.mark.parametrize("chunk", [raster.CHUNK, 7])
def test_agrees_with_the_obvious_way(monkeypatch, chunk):
    monkeypatch.setattr(raster, "CHUNK", chunk)
    corners = np.random.default_rng(0).uniform(-5, 25, size=(12, 3, 3))  # some reach out of the picture
    slowly = rasterise_slowly(corners, 16, 20)
    pixels, triangles, barycentric = rasterise(corners, 16, 20)
    assert pixels.tolist() == sorted(slowly)
    assert triangles.tolist() == [slowly[pixel][0] for pixel in pixels]
    np.testing.assert_allclose(barycentric, [slowly[pixel][1] for pixel in pixels], atol=1e-9)


def test_a_fan_has_no_gaps():
    angles = np.linspace(0, 2 * np.pi, 50)
    rim = np.stack([50 + 40 * np.cos(angles), 50 + 40 * np.sin(angles), 0 * angles], axis=1)
    centre = np.array([50.0, 50.0, 0.0])
    corners = np.array([[centre, a, b] for a, b in zip(rim, rim[1:], strict=False)])
    pixels, _, _ = rasterise(corners, 100, 100)
    row, column = np.divmod(np.arange(100 * 100), 100)
    within = np.flatnonzero(np.hypot(column - 49.5, row - 49.5) < 39.8)
    assert set(within) <= set(pixels)


def test_nothing_to_see():
    edge_on = np.array([[[1.0, 1, 0], [5, 5, 0], [3, 3, 9]]])
    point = np.full((1, 3, 3), 2.5)
    for corners in (np.empty((0, 3, 3)), edge_on + [0.2, 0, 0], point + 0.1, edge_on - 100):
        pixels, triangles, barycentric = rasterise(corners, 8, 8)
        assert (len(pixels), len(triangles), barycentric.shape) == (0, 0, (0, 3))
