"""A picture of a scan with the tapes on it and what they say: whether they lie right is seen at a glance."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, UInt8
from matplotlib.figure import Figure

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.models.measuring.reader import BodyReader, Reading
from lssd_learn.models.measuring.table import lines_of
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.painter import paint

RADIUS = 0.004  # of a tape, over the root of the area
SIDES = 6  # of a tape
AZIMUTHS = (25, 155)


def save_pictures(reader: BodyReader, scans: Collection, found: Mapping[str, Reading], folder: Path) -> None:
    """Write FOLDER/NAME.png of each scan that was read, see `save_picture`.

    Raises:
        InputError: a folder that cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from error
    place = {name: i for i, name in enumerate(scans.names)}
    for name, reading in track(list(found.items()), "pictures"):
        save_picture(reader, scans[place[name]], reading, name, folder / f"{name}.png")


def save_picture(reader: BodyReader, shape: Shape, reading: Reading, name: str, path: Path) -> None:
    """Write a PNG: the scan as `drawn`, and the measures beside."""
    view = drawn(shape, reading, reader)
    height, width = np.array(view.shape[:2]) / 100
    figure = Figure(figsize=(width + 4.6, height))
    axes = figure.subplots(1, 2, width_ratios=[width, 4.6])
    axes[0].imshow(view)
    for axis in axes:
        axis.set_axis_off()
    axes[1].text(0, 0.5, "\n".join(lines_of(reader, name, reading)), family="monospace", fontsize=8.5, va="center")
    figure.subplots_adjust(0, 0, 1, 1, 0.02, 0)
    figure.savefig(path, dpi=100)


def drawn(shape: Shape, reading: Reading, reader: BodyReader) -> UInt8[np.ndarray, "h w 3"]:
    """(h, w, 3) a scan from the front and from behind, its hips upright, with the tapes on it.

    Args:
        shape: the scan that was read; in place of a cloud the body that lies on it is drawn.
    """
    mesh = shape if isinstance(shape, Mesh) else Mesh(reading.points, reader.figure.body.faces)
    vertices, faces = [mesh.vertices @ reading.upright], [mesh.faces]
    for tape in reading.tapes.values():
        more, around = tube(tape @ reading.upright, RADIUS * np.sqrt(mesh.area))
        faces.append(around + sum(map(len, vertices)))
        vertices.append(more)
    whole = Mesh(np.concatenate(vertices), np.concatenate(faces))
    marked = (np.arange(len(whole.vertices)) >= len(mesh.vertices)).astype(float)
    views = [paint(whole, marked, size=700, azimuth=a, limits=(-1.2, 1.2), colormap="coolwarm") for a in AZIMUTHS]
    height = max(len(view) for view in views)
    padded = [np.pad(view, ((0, height - len(view)), (0, 0), (0, 0)), constant_values=255) for view in views]
    return np.concatenate(padded, axis=1)


def tube(points: Float[np.ndarray, "h 3"], radius: float) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, "m 3"]]:
    """Vertices (6h, 3) and faces (12h, 3) of a tube around the polygon through points (h, 3) of about one plane."""
    n, centre = len(points), points.mean(0)
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    out = points - centre
    side = np.cross(along, out)
    turns = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)[:, None, None]
    out, side = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (np.cross(side, along), side))
    vertices = points + radius * (np.cos(turns) * out + np.sin(turns) * side)
    j, i = (grid.ravel() for grid in np.meshgrid(np.arange(SIDES), np.arange(n), indexing="ij"))
    a, b = j * n + i, j * n + (i + 1) % n
    c, d = (j + 1) % SIDES * n + i, (j + 1) % SIDES * n + (i + 1) % n
    return vertices.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
