"""One HTML page that needs nothing else: shapes that turn, numbers, embeddings. Opens from disk, without a network.

The page's own files lie in `page/`; here they are filled with what a comparison found.
"""

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template

import matplotlib
import numpy as np
from matplotlib.colors import to_hex

from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.embeddings import Panel, label_colours
from lssd_learn.view.fields import Field
from lssd_learn.view.moving import encode
from lssd_learn.view.painter import LIGHT
from lssd_learn.view.scenes import upright
from lssd_learn.view.thin import thin

PAGE = Path(__file__).parent / "page"
MOST = 160_000  # vertices a page, some nine megabytes; shapes of more are thinned for it


def write_report(
    path: Path,
    *,
    title: str,
    summary: str,
    shapes: Sequence[Shape],
    names: Sequence[str],
    groups: Sequence[str],
    fields: Sequence[Field],
    panels: Sequence[Panel],
    points: Mapping[str, Sequence],
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    notes: Sequence[str],
    footer: str,
    picture: bytes,
    up: str | None,
    azimuth: float,
) -> None:
    """Write the page. All texts are plain; what could be markup in them is shown as it is.

    Args:
        path: of the file.
        title, summary: what was compared, and what came out.
        shapes: r of them, shown at one scale.
        names, groups: a name and a label for each of these.
        fields: functions on these shapes; the first is shown first.
        panels: embeddings of the whole collection, n points each.
        points: "names" and "labels" (or None), n each.
        header, rows: of the table of numbers; the first column says what they are.
        notes: paragraphs below the table.
        footer: where this comes from.
        picture: a PNG, for browsers without WebGL.
        up: the axis that points up in the shapes; None if unknown.
        azimuth: degrees from which shapes are seen first, as in `paint`.
    """
    data = {
        **scene(shapes, names, groups, fields, up),
        "azimuth": azimuth,
        "embeddings": _embeddings(panels, points["names"], points["labels"]),
    }
    page = Template((PAGE / "page.html").read_text(encoding="utf-8"))
    filled = page.substitute(
        title=escape(title),
        summary=escape(summary),
        table=_table(header, rows),
        notes="\n".join(f'<p class="note">{escape(note)}</p>' for note in notes),
        footer=escape(footer),
        picture=encode(np.frombuffer(picture, np.uint8)),
        data=json.dumps(data).replace("<", "\\u003c"),  # a name may hold the end of a script
        **{name.partition(".")[0]: (PAGE / name).read_text(encoding="utf-8")
           for name in ("style.css", "viewer.js", "charts.js")},
    )  # fmt: skip
    path.write_text(filled, encoding="utf-8")


def scene(
    shapes: Sequence[Shape], names: Sequence[str], groups: Sequence[str], fields: Sequence[Field], up: str | None
) -> dict:
    """Shapes around zero, y up, with the places of their values in the colours, a byte a vertex."""
    made, reach, height, radius = [], 0.0, 0.0, 0.0
    for i, (shape, name, group) in enumerate(zip(shapes, names, groups, strict=True)):
        few, kept = thin(shape, MOST // len(shapes))
        points = upright(few.vertices, up)
        points = points - (points.max(0) + points.min(0)) / 2
        distance = np.linalg.norm(points, axis=1).max()
        reach = max(reach, 2 * (np.hypot(points[:, 0], points[:, 2]).max() if up else distance))
        height = max(height, np.ptp(points[:, 1]) if up else 2 * distance)
        radius = max(radius, distance)
        made.append({
            "name": name,
            "group": group,
            "points": encode(points.astype("<f4")),
            "faces": encode(few.faces.astype("<u4")) if isinstance(few, Mesh) else None,
            "values": [encode(np.round(255 * field.places(i)[kept]).astype(np.uint8)) for field in fields],
        })  # fmt: skip
    ends = [{"low": f"{f.limits[0]:.3g}", "high": f"{f.limits[1]:.3g}"} for f in fields]
    return {
        "shapes": made,
        "fields": [{"title": f.title, "colormap": f.colormap, **end} for f, end in zip(fields, ends, strict=True)],
        "colormaps": {f.colormap: _colormap(f.colormap) for f in fields},
        "extent": [reach or 1.0, height or 1.0],
        "radius": radius or 1.0,
        "upright": up is not None,
        "light": LIGHT.tolist(),
    }


def _embeddings(panels: Sequence[Panel], names: Sequence[str], labels: Sequence[str | None]) -> dict:
    colours = {label: to_hex(colour) for label, colour in label_colours(labels).items()}
    shown = [
        {
            "title": panel.title,
            "points": [[float(f"{x:.5g}") for x in point] for point in np.asarray(panel.points).tolist()],
            "ratios": [f"{ratio:.0%}" for ratio in np.asarray(panel.ratios)[:2].tolist()],
        }
        for panel in panels
    ]
    return {
        "panels": shown,
        "names": [name if label is None else f"{name}: {label}" for name, label in zip(names, labels, strict=True)],
        "fill": [colours[label] for label in labels],
        "colours": [["no label" if label is None else label, colour] for label, colour in colours.items()],
        "order": sorted(range(len(labels)), key=lambda i: labels[i] is not None),  # grey below the others
    }


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = (
        f"<tr><th>{escape(first)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"
        for first, *cells in rows
    )
    return f"<thead><tr>{head}</tr></thead>\n<tbody>\n{chr(10).join(body)}\n</tbody>"


def _colormap(name: str) -> str:
    return encode(np.round(255 * matplotlib.colormaps[name](np.arange(256))[:, :3]).astype(np.uint8))
