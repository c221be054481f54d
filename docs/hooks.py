"""What mkdocs does beside reading pages: formulas become MathML, and three pages are made from what stands elsewhere."""

import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.structure.files import File

from lssd_learn.command.help import ROOMS, tell
from lssd_learn.command.yamls import conf, groups, told

ROOT = Path(__file__).parents[1]
CODE = re.compile(r"(^```.*?^```|`[^`\n]+`)", re.S | re.M)
FORMULA = re.compile(r"\$\$(.+?)\$\$|\$(?=\S)([^$\n]+?)(?<=\S)\$", re.S)

COMMANDS = """\
# The command line

What `lssd --help` and `lssd GROUP=CHOICE --help` tell, made from the same yamls.

```text
{}
```

"""


def on_files(files, config):
    """Add the pages that are made."""
    files.append(File.generated(config, "commands.md", content=commands()))
    files.append(File.generated(config, "changes.md", content=(ROOT / "CHANGELOG.md").read_text(encoding="utf-8")))
    files.append(File.generated(config, "contributing.md", content=contributing()))
    return files


def on_page_markdown(markdown, page, config, files):
    """Formulas between dollars, as GitHub reads them too, but for those in code."""
    parts = CODE.split(markdown)
    return "".join(part if i % 2 else FORMULA.sub(_formula, part) for i, part in enumerate(parts))


def commands() -> str:
    """The help of every choice."""
    text, folders = COMMANDS.format(tell(["--help"])), [conf()]
    there = groups(folders)
    rooms = {choice: (told(folders, "task", choice).target or "..").split(".")[1] for choice in there["task"]}
    for room, title in ROOMS.items():
        text += f"## Tasks: {title[:1].lower()}{title[1:]}\n\n"
        text += "".join(_choice("task", choice) for choice in there["task"] if rooms[choice] == room)
    for group, choices in there.items():
        if group not in ("task", "debug"):
            text += f"## {group}\n\n" + "".join(_choice(group, choice) for choice in choices)
    return text


def contributing() -> str:
    """CONTRIBUTING.md as a page: its links lead from docs/."""
    return (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").replace("](docs/", "](")


def _choice(group: str, choice: str) -> str:
    return f"### {group}={choice}\n\n```text\n{tell([f'{group}={choice}', '--help'])}\n```\n\n"


def _formula(found: re.Match) -> str:
    block, inline = found.groups()
    return f"\n\n{convert(block.strip(), display='block')}\n\n" if block else convert(inline)
