"""The files of `view/page/` put together to a page that needs nothing else: it opens from disk, without a network."""

import json
from html import escape
from pathlib import Path
from string import Template
from typing import Any

PAGE = Path(__file__).parent.parent / "page"
SCRIPTS = " script-src 'unsafe-inline';"  # of a page that has some


def fill(name: str, scripts: tuple[str, ...] = (), /, *, title: str, data: Any = None, **html: str) -> str:
    """The page `name`: after the head that all have, with its own styles first, what its marks stand for.

    The mark $top ends the styles and is the title and the summary.

    Args:
        name: of a file in `view/page/`.
        scripts: files there, each of which has a mark of its own name.
        title: plain text.
        data: what the scripts read, as JSON; what could end a script, such as a name, is escaped.
        html: mark → markup.
    """
    head, top, own = ((PAGE / file).read_text(encoding="utf-8") for file in ("head.html", "top.html", name))
    page = Template(head + own.replace("$top\n", top))
    texts = {file.partition(".")[0]: (PAGE / file).read_text(encoding="utf-8") for file in ("style.css", *scripts)}
    told = {} if data is None else {"data": json.dumps(data).replace("<", "\\u003c")}
    return page.substitute(title=escape(title), scripts=SCRIPTS if scripts else "", **texts, **told, **html)
