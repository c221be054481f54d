"""One HTML page that needs nothing else: shapes that turn, sections of text, tables and charts.

It opens from disk, without a network. The page's own files lie in `view/page/`; here they are filled.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from lssd_learn.view.reports.filled import fill
from lssd_learn.view.reports.stage import Stage, encode, scene


@dataclass(frozen=True)
class Section:
    """A part of a page.

    Attributes:
        title: its heading.
        parts: HTML, of `blocks` and `charts`.
    """

    title: str
    parts: Sequence[str]


def write_page(path: Path, *, title: str, summary: str, stage: Stage, sections: Sequence[Section], footer: str) -> None:
    """Write the page. Texts are plain; what could be markup in them is shown as it is.

    Args:
        path: of the file.
        title, summary: what was asked, and what came out.
        stage: shapes to be turned by hand.
        sections: what follows.
        footer: where this comes from.
    """
    filled = fill(
        "page.html", ("page.js", "ways.js", "camera.js", "viewer.js"),
        title=title,
        data=scene(stage),
        summary=escape(summary),
        hint=escape(stage.hint),
        sections="\n".join(_section(section) for section in sections),
        footer=escape(footer),
        picture=encode(np.frombuffer(stage.picture, np.uint8)),
    )  # fmt: skip
    path.write_text(filled, encoding="utf-8")


def _section(section: Section) -> str:
    parts = "\n".join(section.parts)
    return f"<section>\n<h2>{escape(section.title)}</h2>\n{parts}\n</section>"
