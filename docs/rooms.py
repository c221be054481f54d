"""Draw the rooms of lssd_learn and who uses whom, from the imports: `python docs/rooms.py` makes docs/rooms.png."""

import ast
from collections import Counter
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

PACKAGE = Path(__file__).parents[1] / "lssd_learn"
# From what knows nothing of the others to what knows them all; a row a level.
LEVELS = [
    ["cache"],
    ["shapes", "collections", "maps"],
    ["latent", "differentiable"],
    ["operators", "exploration"],
    ["pipeline", "nets", "view"],
    ["division", "learning", "sweeps"],
    ["models"],
    ["tasks", "measures", "studies"],
    ["command"],
    ["app"],
]
WORDS = {
    "cache": "what one run computed,\nthe next one reads",
    "shapes": "one shape: read, mend,\nLaplacian, eigenbasis",
    "collections": "many shapes: folders,\ngenerated ones, groups",
    "maps": "one functional map,\nhow good it is",
    "latent": "network, latent basis,\ndifferences, push",
    "differentiable": "vertices to operators,\nwith gradients",
    "operators": "algebra on the\nsmall matrices",
    "exploration": "what they tell of groups,\nembedding, evidence",
    "pipeline": "collection → operators,\ncached",
    "nets": "nn.Modules, losses",
    "view": "pictures, charts,\nTensorBoard, pages",
    "division": "who is trained on,\nwho is the test",
    "learning": "data, training,\nwhat a net has to beat",
    "models": "a trained model\nas one object",
    "tasks": "what a user runs",
    "measures": "how good, how fast",
    "studies": "the paper's own\nexperiments",
    "sweeps": "what many runs\nhave left, summed up",
    "command": "a command's words,\nfolder and sizes",
    "app": "the command line",
}
WIDTH, HEIGHT, ACROSS, UP = 2.6, 1.0, 3.6, 1.7


def room(module: str) -> str:
    """The room of a module of the package."""
    return module.split(".")[1] if module.count(".") else ""


def imports() -> tuple[Counter, Counter]:
    """How many files of one room import another, by (room, other); and the lines of each room."""
    arrows, lines = Counter(), Counter()
    for file in sorted(PACKAGE.rglob("*.py")):
        here = file.relative_to(PACKAGE).parts[0].removesuffix(".py")
        text = file.read_text(encoding="utf-8")
        lines[here] += len(text.splitlines())
        named = {node.module or "" for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
        others = {room(name) for name in named if name.startswith("lssd_learn.")} - {here}
        arrows.update((here, other) for other in others)
    return arrows, lines


def direct(arrows: Counter) -> Counter:
    """Without those that follow from others: a room that uses latent may use what latent uses."""

    def reaches(a: str, b: str) -> bool:
        return any(y == b or reaches(y, b) for x, y in arrows if x == a)

    return Counter(
        {
            (a, b): count
            for (a, b), count in arrows.items()
            if not any(x == a and y != b and reaches(y, b) for x, y in arrows)
        }
    )


def draw() -> Figure:
    """The rooms, level under level, with an arrow from each to those that use it, the thicker the more files do."""
    found, lines = imports()
    known = {name for level in LEVELS for name in level}
    arrows = direct(Counter({pair: count for pair, count in found.items() if known.issuperset(pair)}))
    places = {
        name: ((i - (len(level) - 1) / 2) * ACROSS, -row * UP)
        for row, level in enumerate(LEVELS)
        for i, name in enumerate(level)
    }
    figure = Figure(figsize=(10, 10.8), layout="constrained")
    axes = figure.subplots()
    for (user, used), count in arrows.items():
        (x, y), (to_x, to_y) = places[used], places[user]
        if y == to_y:
            side = WIDTH / 2 if to_x > x else -WIDTH / 2
            start, end = (x + side, y), (to_x - side, y)
        else:
            start, end = (x, y - HEIGHT / 2), (to_x, to_y + HEIGHT / 2)
        far = abs(x - to_x) > ACROSS * 1.1 and y == to_y or y - to_y > UP * 1.1
        axes.add_patch(
            FancyArrowPatch(
                start, end, arrowstyle="-|>", mutation_scale=11, linewidth=0.6 + 0.15 * count, color="0.55", zorder=1,
                connectionstyle=f"arc3,rad={0.18 if far else 0}", shrinkA=0, shrinkB=0,
            )
        )  # fmt: skip
    for name, (x, y) in places.items():
        corner = (x - WIDTH / 2, y - HEIGHT / 2)
        axes.add_patch(FancyBboxPatch(corner, WIDTH, HEIGHT, "round,pad=0,rounding_size=0.12", fc="w", ec="0.25"))
        axes.text(x, y + 0.28, name, ha="center", va="center", weight="bold", fontsize=11)
        axes.text(x, y - 0.05, WORDS[name], ha="center", va="center", fontsize=7.5, linespacing=1.1)
        axes.text(x + WIDTH / 2 - 0.08, y - 0.4, f"{lines[name]:,} lines", ha="right", fontsize=6, color="0.4")
    rest = sorted(set(lines) - set(places) - {"__init__"})
    axes.text(
        0,
        -UP * (len(LEVELS) - 1) - 0.95,
        f"beside them: {', '.join(rest)}",
        ha="center",
        fontsize=8,
        color="0.3",
    )
    axes.set(xlim=(-5.2, 5.2), ylim=(-UP * (len(LEVELS) - 1) - 1.2, 0.8))
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


if __name__ == "__main__":
    path = Path(__file__).with_suffix(".png")
    draw().savefig(path, dpi=110)
    print(f"drawn: {path}")
