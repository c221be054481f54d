"""One HTML page on which a person moves through a collection, and a shape follows. Needs no network."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from lssd_learn.exploration.modes import ShapeMap
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.fields import SQUARED, Field
from lssd_learn.view.moving import MOST_VERTICES, moving_mesh
from lssd_learn.view.reports.filled import fill
from lssd_learn.view.reports.stage import Stage, encode, scene
from lssd_learn.view.scenes import upright
from lssd_learn.view.thin import thin

SLIDERS = 8  # principal components that have one
WITHIN = 0.98  # of the vertices of all shapes within the ends of the colours
SCRIPTS = ("page.js", "camera.js", "viewer.js", "moving.js", "explore.js")


def write_explorer(
    path: Path,
    *,
    title: str,
    summary: str,
    mean: Shape,
    moves: ShapeMap,
    names: Sequence[str],
    footer: str,
    up: str | None,
    azimuth: float,
) -> None:
    """Write the page. All texts are plain.

    Args:
        path: of the file.
        title, summary: what is moved through, and how good the map is.
        mean: the shape of coordinates zero; of many vertices fewer are shown.
        moves: of all its vertices.
        names: of the n shapes.
        footer: where this comes from.
        up: the axis that points up; None if unknown.
        azimuth: degrees from which it is seen first, as in `paint`.
    """
    few, kept = thin(mean, MOST_VERTICES)
    points, modes = upright(few.vertices, up), upright(moves.modes[:, kept], up)
    points = points - (points.max(0) + points.min(0)) / 2
    drawn = np.tensordot(moves.coefficients(moves.coordinates), modes, 1)  # the collection's shapes, off the mean
    far = np.linalg.norm(drawn, axis=-1)
    most = float(np.quantile(far, WITHIN)) or 1.0
    field = Field("moved", "distance from the mean shape", [np.zeros(len(points))], (0.0, most), SQUARED)
    shape = Mesh(points, few.faces) if isinstance(few, Mesh) else few
    data = scene(Stage([shape], ["the mean"], [""], [field], "y" if up else None, azimuth, b""))
    reach = points + drawn
    data["extent"] = [float(2 * np.hypot(reach[..., 0], reach[..., 2]).max()), float(2 * np.abs(reach[..., 1]).max())]
    data["radius"] = float(np.linalg.norm(reach, axis=-1).max())
    data |= {
        "moving": moving_mesh(points, modes),
        "map": {
            "coordinates": encode(moves.coordinates.astype("<f4")),
            "linear": encode(moves.linear.astype("<f4")),
            "dual": encode(moves.dual.astype("<f4")),
            "dimensions": moves.linear.shape[0],
            "modes": moves.linear.shape[1],
            "width": moves.width,
        },
        "far": most,
        "fit": True,
        "names": list(names),
        "sliders": min(SLIDERS, moves.coordinates.shape[1]),
    }
    filled = fill("explore.html", SCRIPTS, title=title, data=data, summary=escape(summary), footer=escape(footer))
    path.write_text(filled, encoding="utf-8")
