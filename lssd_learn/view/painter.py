"""Pictures of shapes without OpenGL: shaded meshes or clouds in a row on white, one scale, a function in colour.

The last stage's simplest view, for reports, TensorBoard and figures. Orthographic; `raster.py` finds what is visible.
"""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.triangles import triangle_normals
from lssd_learn.view.raster import rasterise

PLAIN = (0.70, 0.76, 0.84)  # a shape without values
MARGIN = 0.04  # of the longer side, around each shape
OVERSAMPLE = 2
# Towards the light: over the viewer's left shoulder. Columns to the right, rows up, towards the viewer.
LIGHT = np.array([-0.4, 0.55, 0.75]) / np.linalg.norm([-0.4, 0.55, 0.75])


def paint(
    shapes: Shape | Sequence[Shape],
    values: np.ndarray | Sequence[np.ndarray | None] | None = None,
    *,
    size: int = 400,
    azimuth: float = 20.0,
    elevation: float = 10.0,
    up: str = "z",
    colormap: str | None = None,
    limits: tuple[float, float] | None = None,
    point_size: float = 0.012,
) -> np.ndarray:
    """A picture of one shape, or of several in a row at the same scale.

    Args:
        shapes: meshes and clouds.
        values: a (V,) function on the one shape, or one a shape, or None where there is none. All share the colours.
        size: the longer side of the space each shape gets, in pixels.
        azimuth: degrees from which the shape is seen: 0 from the front (from -y, if z is up), 90 from its left (+x).
        elevation: degrees from which it is seen above the horizon.
        up: "z", or "y" for shapes that stand along y and face +z.
        colormap: of matplotlib. By default "coolwarm" if the values have both signs, else "viridis".
        limits: values at the ends of the colormap. By default the range of all values, around 0 if of both signs.
        point_size: radius of the balls of a cloud, as a share of `size`.

    Returns:
        (H, W, 3) uint8, white where there is no shape.

    Raises:
        InputError: no shapes, values that do not fit, an unknown `up` or `colormap`.
    """
    if isinstance(shapes, Mesh | PointCloud):
        shapes, values = [shapes], None if values is None else [np.asarray(values)]
    shapes = list(shapes)
    if not shapes:
        raise InputError("shapes: expected at least one to paint, got none")
    each: list[np.ndarray | None] = [None] * len(shapes)
    each = each if values is None else list(values)
    colours = _colours(shapes, each, colormap, limits)
    rotation = _rotation(azimuth, elevation, up)
    seen = [shape.points @ rotation.T for shape in shapes]  # right, up, towards the viewer

    extents = np.max([np.ptp(points[:, :2], axis=0) for points in seen], axis=0)
    scale = OVERSAMPLE * size * (1 - 2 * MARGIN) / (extents.max() or 1.0)  # all is one point
    border = OVERSAMPLE * size * MARGIN
    width, height = (OVERSAMPLE * np.ceil((extents * scale + 2 * border) / OVERSAMPLE)).astype(int)
    cells = []
    for shape, points, colour in zip(shapes, seen, colours, strict=True):
        middle = (points.max(0) + points.min(0)) / 2
        placed = (points - middle) * scale * [1, -1, -1] + [width / 2, height / 2, 0]  # column, row, depth
        how = placed, colour, height, width, OVERSAMPLE * size * point_size
        cells.append(_paint_mesh(shape, *how) if isinstance(shape, Mesh) else _paint_cloud(shape, *how))
    image = np.concatenate(cells, axis=1)
    image = image.reshape(height // OVERSAMPLE, OVERSAMPLE, -1, OVERSAMPLE, 3).mean(1).mean(2)
    return np.round(255 * image).astype(np.uint8)


def save_png(image: np.ndarray, path: str | Path) -> None:
    """Write an (H, W, 3) uint8 picture as PNG.

    Raises:
        InputError: the folder does not exist.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    Image.fromarray(image).save(path, format="PNG")


def _rotation(azimuth: float, elevation: float, up: str) -> np.ndarray:
    """(3, 3) rows: the directions to the right, up and towards the viewer, in the coordinates of the shape."""
    if up not in ("y", "z"):
        raise InputError(f"up: expected 'y' or 'z', got {up!r}")
    a, e = np.radians([azimuth, elevation])
    right = [np.cos(a), np.sin(a), 0]
    towards = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    view = np.array([right, np.cross(towards, right), towards])
    to_z_up = np.eye(3) if up == "z" else np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    return view @ to_z_up


def _colours(
    shapes: list[Shape], values: list[np.ndarray | None], colormap: str | None, limits: tuple[float, float] | None
) -> list[np.ndarray]:
    """(V, 3) colours a shape."""
    if len(values) != len(shapes):
        raise InputError(f"values: expected one function for each of {len(shapes)} shapes, got {len(values)}")
    values = [None if v is None else np.asarray(v, dtype=float) for v in values]
    for i, (shape, v) in enumerate(zip(shapes, values, strict=True)):
        if v is not None and (v.shape != (len(shape.points),) or not np.isfinite(v).all()):
            raise InputError(f"values: expected {len(shape.points)} finite numbers for shape {i}, got {v.shape}")
    if colormap is not None and colormap not in matplotlib.colormaps:
        raise InputError(f"colormap: expected one that matplotlib knows, such as 'viridis', got {colormap!r}")
    given = [v for v in values if v is not None]
    low, high = limits or ((min(v.min() for v in given), max(v.max() for v in given)) if given else (0, 1))
    if limits is None and low < 0 < high:
        low, high = -max(-low, high), max(-low, high)
    chosen = matplotlib.colormaps[colormap or ("coolwarm" if low < 0 < high else "viridis")]
    plain = np.array(PLAIN)
    return [
        np.tile(plain, (len(shape.points), 1)) if v is None else chosen((v - low) / ((high - low) or 1))[:, :3]
        for shape, v in zip(shapes, values, strict=True)
    ]


def _paint_mesh(mesh: Mesh, placed: np.ndarray, colour: np.ndarray, height: int, width: int, _: float) -> np.ndarray:
    corners = placed[mesh.faces]
    pixels, triangles, barycentric = rasterise(corners, height, width)
    seen = mesh.faces[triangles]
    # Rows go down and depths away from the viewer, where normals count up and towards.
    normal = np.einsum("pi,pic->pc", barycentric, normals(mesh, placed)[seen]) * [1, -1, -1]
    normal *= np.where(triangle_normals(corners[triangles])[:, 2:] > 0, -1.0, 1.0)  # the inside is lit too
    return _shade(pixels, np.einsum("pi,pic->pc", barycentric, colour[seen]), _unit(normal), height, width)


def _paint_cloud(
    cloud: PointCloud, placed: np.ndarray, colour: np.ndarray, height: int, width: int, radius: float
) -> np.ndarray:
    """Every point a little ball."""
    reach = int(np.ceil(radius))
    columns, rows = (grid.ravel() for grid in np.meshgrid(*[np.arange(-reach, reach + 1)] * 2))
    within = columns**2 + rows**2 <= radius**2
    columns, rows = columns[within], rows[within]
    bulge = np.sqrt(np.maximum(radius**2 - columns**2 - rows**2, 0))
    column = np.floor(placed[:, :1]).astype(int) + columns
    row = np.floor(placed[:, 1:2]).astype(int) + rows
    depth = placed[:, 2:] - bulge
    kept = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    pixel = row * width + column
    nearest = np.full(height * width, np.inf)
    np.minimum.at(nearest, pixel[kept], depth[kept])
    point, place = np.nonzero(kept)
    wins = depth[point, place] == nearest[pixel[point, place]]
    point, place = point[wins], place[wins]
    normal = np.stack([columns, -rows, bulge], axis=1)[place]
    return _shade(pixel[point, place], colour[point], _unit(normal), height, width)


def _shade(pixels: np.ndarray, colour: np.ndarray, normal: np.ndarray, height: int, width: int) -> np.ndarray:
    """(height, width, 3) picture in [0, 1]: ambient and soft diffuse light, a little darker towards the outline."""
    diffuse = (0.5 + 0.5 * (normal @ LIGHT)) ** 1.5
    outline = 0.8 + 0.2 * np.clip(normal[:, 2], 0, 1)
    image = np.ones((height * width, 3))
    image[pixels] = np.clip(colour * ((0.35 + 0.75 * diffuse) * outline)[:, None], 0, 1)
    return image.reshape(height, width, 3)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)
