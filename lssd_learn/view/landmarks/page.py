"""`landmarks.html`: the landmarks that were carried, the doubtful ones first, for a person to check. Needs no network.

A card shows a landmark where it was carried to, close up, beside the same landmark where it was given, seen alike.
"""

import io
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import cast

import numpy as np
from jaxtyping import Bool, Float
from PIL import Image

from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.landmarks.pictures import CHECK, PLAIN, close_up, turned_like, view_of, whole
from lssd_learn.view.reports.filled import fill

SHARE, LEAST, MOST = 0.05, 5, 48  # of the carried landmarks those to be checked: so many, but no fewer and no more
ALIKE = 4  # of one name at most: what is wrong with these is seen after a few
SHOWN = 60  # shapes in pictures


@dataclass(frozen=True, eq=False)
class Sheet:
    """What the page shows.

    Attributes:
        shapes: n meshes, a collection of them for example.
        names: of them.
        labels: of L landmarks.
        points: (n, L, 3), NaN where there is none.
        bars: (n, L) errors to be expected; NaN where nobody knows.
        carried: (n, L) which landmarks were carried.
        hubs: numbers of the shapes that they come from.
        lost: names of the shapes that got none.
        slips: given landmarks that are far from where the others say them, in words.
    """

    shapes: Sequence[Shape]
    names: Sequence[str]
    labels: Sequence[str]
    points: Float[np.ndarray, "n L 3"]
    bars: Float[np.ndarray, "n L"]
    carried: Bool[np.ndarray, "n L"]
    hubs: Sequence[int]
    lost: Sequence[str] = ()
    slips: Sequence[str] = ()

    def mesh(self, i: int) -> Mesh:
        """Shape i."""
        return cast(Mesh, self.shapes[i])

    @property
    def doubtful(self) -> list[tuple[int, int]]:
        """Shape and landmark of those to be checked, the largest bars first; without bars none."""
        known = np.argwhere(self.carried & np.isfinite(self.bars)).tolist()
        count = min(MOST, max(LEAST, round(SHARE * len(known))))
        chosen: list[tuple[int, int]] = []
        for i, mark in sorted(known, key=lambda one: -self.bars[tuple(one)]):
            if sum(other == mark for _, other in chosen) < ALIKE and len(chosen) < count:
                chosen.append((i, mark))
        return chosen


def write_landmark_page(path: Path, sheet: Sheet) -> None:
    """Write the page.

    Args:
        path: of the file.
        sheet: what it shows.
    """
    doubtful = sheet.doubtful
    filled = fill(
        "landmarks.html",
        title="Carried landmarks",
        summary=escape(_summary(sheet, len(doubtful))),
        index=" · ".join(_link(i, mark, _title(sheet, i, mark)) for i, mark in doubtful),
        cards="\n".join(_card(sheet, i, mark) for i, mark in doubtful) or "<p>None is known to be.</p>",
        shapes="\n".join(_shapes(sheet, doubtful)),
        table=_table(sheet, set(doubtful)),
    )
    path.write_text(filled, encoding="utf-8")


def _summary(sheet: Sheet, count: int) -> str:
    shapes = int(sheet.carried.any(axis=1).sum())
    said = f"{int(sheet.carried.sum()):,} landmarks carried to {shapes:,} shapes from {len(sheet.hubs)}."
    if count:
        said += f" The {count} with the largest error bars, {ALIKE} of a name at most, come first."
    else:
        said += " There are no error bars: three shapes with landmarks or more give them."
    if sheet.slips:
        said += (
            f" Given, but far from where the others say them: {', '.join(sheet.slips)}; look whether they are right."
        )
    if sheet.lost:
        said += f" No map was to be trusted of, so that they got none: {', '.join(sheet.lost)}."
    return said


def _card(sheet: Sheet, i: int, mark: int) -> str:
    """One landmark, beside the same one on the hub whose landmarks lie most like it."""
    shape, points = sheet.mesh(i), sheet.points[i]
    view = view_of(shape, points[mark])
    pictures = [(whole(shape, points, _values(sheet, mark), view), sheet.names[i]),
                (close_up(shape, points, mark, view), "carried")]  # fmt: skip
    h = next((h for h in sheet.hubs if np.isfinite(sheet.points[h, mark]).all() and not sheet.carried[h, mark]), None)
    if h is not None:
        hub, theirs = sheet.mesh(h), sheet.points[h]
        alike = turned_like(view, hub, theirs, shape, points)
        pictures.append((close_up(hub, theirs, mark, alike), f"given on {sheet.names[h]}"))
    head = f"{escape(_title(sheet, i, mark))} <small>± {sheet.bars[i, mark]:.3g}</small>"
    views = "".join(_picture(image, text) for image, text in pictures)
    return f'<figure class="card" id="{_anchor(i, mark)}"><h3>{head}</h3>{views}</figure>'


def _values(sheet: Sheet, mark: int) -> list[float]:
    return [CHECK if other == mark else PLAIN for other in range(len(sheet.labels))]


def _shapes(sheet: Sheet, doubtful: Sequence[tuple[int, int]]) -> list[str]:
    """Every shape with all its landmarks, from both sides, the most doubtful first; of very many the first."""
    with np.errstate(invalid="ignore"):
        worst = np.where(np.isfinite(sheet.bars), sheet.bars, 0).max(axis=1)
    there = [int(i) for i in np.argsort(-worst, kind="stable") if sheet.carried[i].any()]
    made = []
    for i in there[:SHOWN]:
        shape, points = sheet.mesh(i), sheet.points[i]
        values = [CHECK if (i, mark) in doubtful else PLAIN for mark in range(len(sheet.labels))]
        view = _flat(shape)
        sides = (view, view * [[-1], [1], [-1]])
        pictures = "".join(_picture(whole(shape, points, values, side, 200), "") for side in sides)
        checked = [sheet.labels[mark] for mark in range(len(values)) if values[mark] == CHECK]
        text = f"{sheet.names[i]}{': check ' + ', '.join(checked) if checked else ''}"
        made.append(f'<figure class="shape">{pictures}<figcaption>{escape(text)}</figcaption></figure>')
    if len(there) > SHOWN:
        made.append(f'<p class="note">{len(there) - SHOWN:,} shapes more are in the table only.</p>')
    return made


def _flat(shape: Mesh) -> np.ndarray:
    """(3, 3) the view in which a shape is seen at its broadest, its long axis up."""
    centred = shape.vertices - shape.vertices.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    return np.stack([np.cross(axes[2], axes[0]), axes[2], axes[0]])


def _table(sheet: Sheet, doubtful: set[tuple[int, int]]) -> str:
    """A row a shape: the error bar of every landmark."""
    head = "".join(f"<th>{escape(label)}</th>" for label in sheet.labels)
    rows = []
    for i, name in enumerate(sheet.names):
        if sheet.carried[i].any():
            cells = "".join(_cell(sheet, i, mark, (i, mark) in doubtful) for mark in range(len(sheet.labels)))
            rows.append(f"<tr><th>{escape(name)}</th>{cells}</tr>")
    return f"<thead><tr><th></th>{head}</tr></thead>\n<tbody>\n{chr(10).join(rows)}\n</tbody>"


def _cell(sheet: Sheet, i: int, mark: int, is_doubtful: bool) -> str:
    if not sheet.carried[i, mark]:
        return f"<td>{'given' if np.isfinite(sheet.points[i, mark]).all() else 'none'}</td>"
    bar = sheet.bars[i, mark]
    text = f"{bar:.2g}" if np.isfinite(bar) else "?"
    return f'<td class="check">{_link(i, mark, text)}</td>' if is_doubtful else f"<td>{text}</td>"


def _title(sheet: Sheet, i: int, mark: int) -> str:
    return f"{sheet.labels[mark]} of {sheet.names[i]}"


def _link(i: int, mark: int, text: str) -> str:
    return f'<a href="#{_anchor(i, mark)}">{escape(text)}</a>'


def _anchor(i: int, mark: int) -> str:
    return f"check-{i}-{mark}"


def _picture(image: np.ndarray, text: str) -> str:
    stream = io.BytesIO()
    Image.fromarray(image).save(stream, format="PNG", optimize=True)
    data = b64encode(stream.getvalue()).decode()
    words = f"<span>{escape(text)}</span>" if text else ""
    return f'<span class="view"><img alt="{escape(text)}" src="data:image/png;base64,{data}">{words}</span>'
