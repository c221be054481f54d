"""Which triangle each pixel shows: a z-buffer in numpy. `painter.py` projects and shades around it."""

from collections.abc import Iterator

import numpy as np

from lssd_learn.shapes.triangles import triangle_normals

# Pixels tried at once, which bounds the memory.
CHUNK = 1 << 20


def rasterise(corners: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nearest triangle at the centre of each pixel.

    Args:
        corners: (F, 3, 3) the corners of each triangle: column and row in pixels (the centre of the first pixel is
            at .5, .5) and depth, which grows away from the viewer.
        height, width: size of the picture.

    Returns:
        pixels: (P,) the covered pixels, row · width + column.
        triangles: (P,) the triangle that each shows; the first of equally near ones.
        barycentric: (P, 3) where in the triangle.
    """
    depth = np.full(height * width, np.inf)
    triangle = np.full(height * width, -1)
    slope = _slopes(corners)
    low, high = corners[..., 2].min(1), corners[..., 2].max(1)
    for face, row, column in _covered(corners[..., :2], height, width):
        x, y = column + 0.5 - corners[face, 0, 0], row + 0.5 - corners[face, 0, 1]
        z = corners[face, 0, 2] + slope[face, 0] * x + slope[face, 1] * y
        z = np.clip(z, low[face], high[face])  # the slope of a sliver is all rounding
        pixel = row * width + column
        before = depth[pixel]
        np.minimum.at(depth, pixel, z)
        wins = np.flatnonzero((z == depth[pixel]) & (z < before))[::-1]  # backwards: the first one is written last
        triangle[pixel[wins]] = face[wins]
    pixels = np.flatnonzero(triangle >= 0)
    return pixels, triangle[pixels], _barycentric(corners[triangle[pixels], :, :2], pixels, width)


def _covered(corners: np.ndarray, height: int, width: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Triangle, row and column of every pixel whose centre is in a triangle, in the order of triangles, in chunks."""
    first = np.clip(np.ceil(corners[..., 1].min(1) - 0.5), 0, height).astype(int)
    last = np.clip(np.floor(corners[..., 1].max(1) - 0.5) + 1, 0, height).astype(int)
    face, offset = _expand(np.maximum(last - first, 0))
    row = first[face] + offset
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for i in range(3):  # where the edges cross the middle of the row
        (ax, ay), (bx, by) = corners[face, i].T, corners[face, i - 1].T
        y = row + 0.5
        with np.errstate(divide="ignore", invalid="ignore"):  # edges along the row do not cross it
            x = ax + (y - ay) * ((bx - ax) / (by - ay))
        crosses = (ay <= y) != (by <= y)
        left, right = np.where(crosses, np.minimum(left, x), left), np.where(crosses, np.maximum(right, x), right)
    start = np.ceil(np.clip(left - 0.5, 0, width)).astype(int)
    count = np.maximum(np.floor(np.clip(right - 0.5, -1, width - 1)).astype(int) + 1 - start, 0)
    ends = np.cumsum(count)
    begin = 0
    while begin < len(ends):
        end = np.searchsorted(ends, ends[begin] - count[begin] + CHUNK, side="right")
        end = max(int(end), begin + 1)
        span, offset = _expand(count[begin:end])
        span += begin
        yield face[span], row[span], start[span] + offset
        begin = end


def _expand(count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each index i count[i] times, and beside it 0, 1, … count[i] - 1."""
    index = np.repeat(np.arange(len(count)), count)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(count) - count, count)


def _slopes(corners: np.ndarray) -> np.ndarray:
    """(F, 2) by how much the depth grows a column and a row; 0 for a triangle seen edge-on."""
    normal = triangle_normals(corners)
    flat = normal[:, 2] == 0
    return np.where(flat[:, None], 0, -normal[:, :2] / np.where(flat, 1, normal[:, 2])[:, None])


def _barycentric(corners: np.ndarray, pixels: np.ndarray, width: int) -> np.ndarray:
    """(P, 3) coordinates of the centres of `pixels` in the triangles `corners` (P, 3, 2)."""
    row, column = np.divmod(pixels, width)
    a, b, c = (corners[:, i] - np.stack([column + 0.5, row + 0.5], axis=1) for i in range(3))
    weights = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    total = weights.sum(1, keepdims=True)
    weights = np.where(total == 0, 1 / 3, weights / np.where(total == 0, 1, total))
    return np.clip(weights, 0, 1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
