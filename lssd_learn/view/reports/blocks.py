"""Pieces of a page as HTML: tables, paragraphs, lists. Texts are plain; what could be markup is shown as it is."""

from collections.abc import Mapping, Sequence
from html import escape


def table(header: Sequence[str], rows: Sequence[Sequence[str]], names: int = 1) -> str:
    """A table that scrolls sideways where it is too wide.

    Args:
        header: of the columns.
        rows: as many cells each.
        names: so many columns on the left say what the row is.
    """
    head = "".join(f"<th{' class=name' if j < names else ''}>{escape(cell)}</th>" for j, cell in enumerate(header))
    lines = (
        "".join(f"<th>{escape(c)}</th>" if j < names else f"<td>{escape(c)}</td>" for j, c in enumerate(row))
        for row in rows
    )
    body = "\n".join(f"<tr>{line}</tr>" for line in lines)
    return f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>'


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph; `kind` "note" is small and grey."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def words(meanings: Mapping[str, str]) -> str:
    """What each name means, for a person who has not met it."""
    lines = "\n".join(f"<dt>{escape(name)}</dt><dd>{escape(said)}</dd>" for name, said in meanings.items())
    return f"<dl>\n{lines}\n</dl>"


def folded(title: str, inside: str) -> str:
    """What is shown when one asks for it; on paper always."""
    return f"<details><summary>{escape(title)}</summary>\n{inside}\n</details>"


def listed(lines: Sequence[str]) -> str:
    """A list."""
    return "<ul>\n" + "\n".join(f"<li>{escape(line)}</li>" for line in lines) + "\n</ul>"
