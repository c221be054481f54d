"""Shapes for the canvas of a page: their points, faces, colours and ways as plain data."""

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field

import matplotlib
import numpy as np
from jaxtyping import Float

from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.fields import Field
from lssd_learn.view.painter import LIGHT
from lssd_learn.view.scenes import upright
from lssd_learn.view.thin import thin

MOST = 160_000  # vertices a page, some nine megabytes; shapes of more are thinned for it, ways count as shapes
STEPS = 65_535  # of a coordinate between the ends of a way


@dataclass(frozen=True, eq=False)
class Way:
    """A line of surfaces that the first shape of a stage can take: middle + s · step.

    Attributes:
        title: what changes.
        ends: what s = −1 and s = 1 are.
        middle, step: (V, 3), in the vertices of the first shape.
        at: values of a number at the ends; None where there is none.
        field: number of the field that shows what changes; None is none of its own.
    """

    title: str
    ends: tuple[str, str]
    middle: Float[np.ndarray, "V 3"]
    step: Float[np.ndarray, "V 3"]
    at: tuple[float, float] | None = None
    field: int | None = None


@dataclass(frozen=True, eq=False)
class Stage:
    """What the canvas shows.

    Attributes:
        shapes: r of them, shown at one scale.
        names, groups: a name and a label for each of these.
        fields: functions on these shapes; the first is shown first.
        up: the axis that points up in the shapes; None if unknown.
        azimuth: degrees from which shapes are seen first, as in `paint`.
        picture: a PNG, for browsers without WebGL.
        hint: a paragraph about what is seen.
        ways: of the first shape; one can be chosen, and gone along by a slider.
    """

    shapes: Sequence[Shape]
    names: Sequence[str]
    groups: Sequence[str]
    fields: Sequence[Field]
    up: str | None
    azimuth: float
    picture: bytes
    hint: str = ""
    ways: Sequence[Way] = field(default_factory=tuple)


def scene(stage: Stage) -> dict:
    """Shapes around zero, y up, with the places of their values in the colours, a byte a vertex."""
    made, reach, height, radius = [], 0.0, 0.0, 0.0
    ways, fields, up = stage.ways, stage.fields, stage.up
    for i, (shape, name, group) in enumerate(zip(stage.shapes, stage.names, stage.groups, strict=True)):
        few, kept = thin(shape, MOST // (len(stage.shapes) + len(ways)))
        lines = [(upright(way.middle[kept], up), upright(way.step[kept], up)) for way in ways] if i == 0 else []
        points = upright(few.vertices, up)
        seen = np.concatenate([points, *(middle + s * step for middle, step in lines for s in (-1, 1))])
        centre = (seen.max(0) + seen.min(0)) / 2
        points, seen = points - centre, seen - centre
        distance = np.linalg.norm(seen, axis=1).max()
        reach = max(reach, 2 * (np.hypot(seen[:, 0], seen[:, 2]).max() if up else distance))
        height = max(height, np.ptp(seen[:, 1]) if up else 2 * distance)
        radius = max(radius, distance)
        made.append({
            "name": name,
            "group": group,
            "points": encode(points.astype("<f4")),
            "faces": encode(few.faces.astype("<u4")) if isinstance(few, Mesh) else None,
            "values": [encode(np.round(255 * f.places(i)[kept]).astype(np.uint8)) for f in fields],
            "ways": [_way(way, middle - centre, step) for way, (middle, step) in zip(ways, lines, strict=False)],
        })  # fmt: skip
    ends = [{"low": f"{f.limits[0]:.3g}", "high": f"{f.limits[1]:.3g}"} for f in fields]
    return {
        "shapes": made,
        "fields": [{"title": f.title, "colormap": f.colormap, **end} for f, end in zip(fields, ends, strict=True)],
        "colormaps": {f.colormap: _colormap(f.colormap) for f in fields},
        "extent": [reach or 1.0, height or 1.0],
        "radius": radius or 1.0,
        "upright": up is not None,
        "axes": upright(np.eye(3), up).tolist(),
        "azimuth": stage.azimuth,
        "light": LIGHT.tolist(),
    }


def encode(array: np.ndarray) -> str:
    """The bytes of an array in base64."""
    return b64encode(np.ascontiguousarray(array).tobytes()).decode()


def _way(way: Way, middle: np.ndarray, step: np.ndarray) -> dict:
    """Points in 16 bits between the lowest and the highest coordinate there is, less than a pixel."""
    packed = {name: _packed(values) for name, values in (("middle", middle), ("step", step))}
    return {"title": way.title, "ends": way.ends, "at": way.at, "field": way.field, **packed}


def _packed(values: np.ndarray) -> dict:
    low, high = float(values.min()), float(values.max())
    scale = (high - low) / STEPS or 1.0
    return {"low": low, "scale": scale, "codes": encode(np.round((values - low) / scale).astype("<u2"))}


def _colormap(name: str) -> str:
    return encode(np.round(255 * matplotlib.colormaps[name](np.arange(256))[:, :3]).astype(np.uint8))
