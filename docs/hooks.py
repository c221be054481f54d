"""What mkdocs does beside reading pages: formulas become MathML, and pages are made from what stands elsewhere."""

import ast
import base64
import json
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
    text, pictures = lesson()
    files.append(File.generated(config, "lesson.md", content=text))
    for name, picture in pictures.items():
        files.append(File.generated(config, name, content=picture))
    return files


def on_page_markdown(markdown, page, config, files):
    """Formulas between dollars, as GitHub reads them too, but for those in code; and what a room's page would miss."""
    if (room := re.fullmatch(r"reference/(\w+)\.md", page.file.src_uri)) and room[1] != "index":
        markdown += "".join(f"\n\n::: lssd_learn.{room[1]}.{name}\n    options:\n      show_root_heading: true\n"
                            for name in hidden(room[1]))  # fmt: skip
    if page.file.src_uri != "lesson.md":
        markdown = markdown.replace("(lesson.ipynb)", "(lesson.md)")
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


def hidden(room: str) -> list[str]:
    """What a room offers under the name of one of its files, which is found in its place: eigenbasis.eigenbasis."""
    folder = ROOT / "lssd_learn" / room
    tree = ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))
    taken = [
        (node.module, alias.name) for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names
    ]
    return [f"{name}.{name}" for module, name in taken if module and module == f"lssd_learn.{room}.{name}"]


def contributing() -> str:
    """CONTRIBUTING.md as a page: its links lead from docs/."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return text.replace("](docs/", "](").replace("[CODE_OF_CONDUCT.md](CODE_OF_CONDUCT.md)", "`CODE_OF_CONDUCT.md`")


def lesson() -> tuple[str, dict[str, bytes]]:
    """docs/lesson.ipynb as a page, with what its cells have printed and drawn; and the pictures by their names."""
    parts, pictures = [], {}
    for cell in json.loads((ROOT / "docs" / "lesson.ipynb").read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        for output in cell.get("outputs", ()):
            data = output.get("data", {"text/plain": output.get("text", "")})
            if "image/png" in data:
                name = f"lesson/{len(pictures):02d}.png"
                pictures[name] = base64.b64decode("".join(data["image/png"]))
                parts.append(f"![What the cell draws]({name})")
            elif "text/html" not in data:  # a progress bar
                parts.append(f"```text\n{''.join(data['text/plain']).rstrip()}\n```")
    head, *rest = parts
    return "\n\n".join([f"{head}\n\nThe notebook itself: [lesson.ipynb](lesson.ipynb).", *rest]), pictures


def _choice(group: str, choice: str) -> str:
    return f"### {group}={choice}\n\n```text\n{tell([f'{group}={choice}', '--help'])}\n```\n\n"


def _formula(found: re.Match) -> str:
    block, inline = found.groups()
    if not block:
        return f"<span>{convert(inline)}</span>"  # at the start of a line <math> alone would begin a block
    return f'\n\n<div class="formula">{convert(block.strip(), display="block")}</div>\n\n'
