"""Charts of a page as SVG: points with hulls and the shapes at the ends of their axes, histograms, confusions.

They are drawn here and not by a script, so that they print, and stand where scripts are forbidden.
"""

from collections.abc import Sequence
from html import escape

import numpy as np
from jaxtyping import Float, Int
from matplotlib.colors import to_hex
from matplotlib.ticker import MaxNLocator
from scipy.spatial import ConvexHull, QhullError

from lssd_learn.view.embeddings import label_colours

WIDTH, HEIGHT = 460, 360
LEFT, RIGHT, TOP, BOTTOM = 54, 14, 14, 44  # pixels around what is drawn
SOFT, LINE, BAR, OWN = "#5b6577", "#dfe3ea", "#8fa8c8", "#b40426"
END = 84  # pixels of the picture of a shape at the end of an axis
BINS = 30


class Axes:
    """From values to places in a drawing of WIDTH by HEIGHT, and its frame with numbers and names."""

    def __init__(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        left: float = LEFT,
        bottom: float = BOTTOM,
        top: float = TOP,
    ):
        self.x, self.y = x, y
        self.box = (left, WIDTH - RIGHT, HEIGHT - bottom, top)  # left, right, bottom, top

    def across(self, value: float) -> float:
        left, right, _, _ = self.box
        return left + (value - self.x[0]) / (self.x[1] - self.x[0]) * (right - left)

    def up(self, value: float) -> float:
        _, _, bottom, top = self.box
        return bottom - (value - self.y[0]) / (self.y[1] - self.y[0]) * (bottom - top)

    def frame(self, x: str, y: str) -> list[str]:
        """Lines at round numbers, these numbers, the names of the axes."""
        left, right, bottom, top = self.box
        found = []
        for value in _ticks(self.x):
            at = self.across(value)
            found.append(_line(at, top, at, bottom))
            found.append(_text(at, bottom + 14, f"{value:g}", size=10))
        for value in _ticks(self.y):
            at = self.up(value)
            found.append(_line(left, at, right, at))
            found.append(_text(left - 5, at + 3.5, f"{value:g}", "end", 10))
        found.append(_text((left + right) / 2, bottom + 32, x))
        middle = (top + bottom) / 2
        turned = f'transform="rotate(-90 14 {middle:.1f})"'
        return [*found, _text(14, middle, y, more=turned)]


def scatter(
    points: Float[np.ndarray, "n 2"],
    names: Sequence[str],
    labels: Sequence[str | None],
    axes: tuple[str, str],
    title: str,
    ends: Sequence[str] = (),
) -> str:
    """A circle a shape, named when one points at it; around each group its convex hull.

    Args:
        points: (n, 2).
        names, labels: n; the colour is that of the label, grey for None, which is in no hull.
        axes: their names, with the part of the variance.
        title: of the figure.
        ends: addresses of four pictures, of the shapes at the low and high end of the first axis and of the second.
    """
    points = np.asarray(points, dtype=float)
    low, high = points.min(0), points.max(0)
    room = 0.06 * np.where(high > low, high - low, 1)
    wide, high_ = (END, END) if len(ends) else (0, 0)
    drawn = Axes(
        (float(low[0] - room[0]), float(high[0] + room[0])), (float(low[1] - room[1]), float(high[1] + room[1])),
        LEFT + wide, BOTTOM + high_,
    )  # fmt: skip
    found = drawn.frame(*axes)
    places = np.array([[drawn.across(x), drawn.up(y)] for x, y in points])
    colours = {label: to_hex(colour) for label, colour in label_colours(labels).items()}
    for label, colour in colours.items():
        own = places[[other == label for other in labels]]
        outline = "" if label is None else _hull(own)
        if outline:
            found.append(f'<polygon points="{outline}" fill="{colour}" fill-opacity=".1" stroke="{colour}"/>')
    order = sorted(range(len(labels)), key=lambda i: labels[i] is not None)
    for i in order:
        name = names[i] if labels[i] is None else f"{names[i]}: {labels[i]}"
        (x, y), colour = places[i], colours[labels[i]]
        found.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}" stroke="#fff" stroke-width=".8" tabindex="0">'
            f"<title>{escape(name)}</title></circle>"
        )
    if ends:
        left, right, bottom, top = drawn.box
        below = bottom + BOTTOM - 6
        corners = [(left - 20, below), (right - END + 10, below), (20, bottom - END + 10), (20, top)]
        found += [
            f'<image x="{x:.0f}" y="{y:.0f}" width="{END}" height="{END}" href="{address}"/>'
            for (x, y), address in zip(corners, ends, strict=True)
        ]
    return _figure(title, found, _legend(colours) if len(colours) > 1 else "")


def histogram(found: Float[np.ndarray, " N"], title: str, what: str, said: str) -> str:
    """Statistics under permutations, and in red that of the data, which is the first.

    Args:
        found: (N,).
        title: of the figure.
        what: the statistic.
        said: the p-value, in words.
    """
    found = np.asarray(found, dtype=float)
    edges = np.linspace(found.min(), found.max() if found.max() > found.min() else found.min() + 1, BINS + 1)
    counts, _ = np.histogram(found, edges)
    axes = Axes((float(edges[0]), float(edges[-1])), (0.0, 1.1 * float(counts.max())))
    drawn = axes.frame(what, "permutations")
    for count, a, b in zip(counts, edges, edges[1:], strict=False):
        x, y = axes.across(a), axes.up(float(count))
        drawn.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{axes.across(b) - x - 1:.1f}" height="{axes.up(0) - y:.1f}" '
            f'fill="{BAR}">'
            f"<title>{count} from {a:.3g} to {b:.3g}</title></rect>"
        )
    at = axes.across(float(found[0]))
    drawn.append(
        f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{axes.box[3]}" y2="{axes.box[2]}" stroke="{OWN}" stroke-width="2"/>'
    )
    left = at > WIDTH / 2
    drawn.append(_text(at + (-6 if left else 6), axes.box[3] + 12, said, "end" if left else "start", colour=OWN))
    return _figure(title, drawn)


def confusion(counts: Int[np.ndarray, "g g"], labels: Sequence[str], title: str) -> str:
    """How many shapes of each group (rows) are taken for which (columns)."""
    shares = counts / np.maximum(counts.sum(1, keepdims=True), 1)
    head = "".join(f"<th>{escape(label)}</th>" for label in labels)
    lines = []
    for label, row, share in zip(labels, counts, shares, strict=True):
        cells = "".join(
            f'<td style="background:rgba(59,76,192,{0.65 * s:.2f});color:{"#fff" if s > 0.6 else "inherit"}">'
            f"{int(c)}</td>"
            for c, s in zip(row, share, strict=True)
        )
        lines.append(f"<tr><th>{escape(label)}</th>{cells}</tr>")
    body = "\n".join(lines)
    return (
        f'<figure class="confusion"><figcaption>{escape(title)}</figcaption><div class="wide"><table>'
        f"<thead><tr><th>is ↓ taken for →</th>{head}</tr></thead><tbody>{body}</tbody></table></div></figure>"
    )


def grid(figures: Sequence[str]) -> str:
    """Figures side by side, as many as there is room for."""
    return '<div class="charts">\n' + "\n".join(figures) + "\n</div>"


def _figure(title: str, inside: Sequence[str], below: str = "") -> str:
    drawing = "\n".join(inside)
    return (
        f"<figure><figcaption>{escape(title)}</figcaption>"
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="system-ui, sans-serif" aria-label="{escape(title)}">\n{drawing}\n</svg>{below}</figure>'
    )


def _legend(colours: dict[str | None, str]) -> str:
    entries = "".join(
        f'<span><i style="background:{colour}"></i>{escape("no label" if label is None else label)}</span>'
        for label, colour in colours.items()
    )
    return f'<div class="legend">{entries}</div>'


def _hull(points: np.ndarray) -> str:
    """Its corners; "" of fewer than three points, or of points on a line."""
    try:
        corners = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return ""
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)


def _ticks(ends: tuple[float, float]) -> list[float]:
    return [float(v) for v in MaxNLocator(5).tick_values(*ends) if ends[0] <= v <= ends[1]]


def _line(x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{LINE}"/>'


def _text(
    x: float, y: float, text: str, anchor: str = "middle", size: int = 12, colour: str = SOFT, more: str = ""
) -> str:
    where = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" fill="{colour}" {more}'
    return f"<text {where}>{escape(text)}</text>"
