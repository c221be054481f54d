"""Draws docs/girths.png: where the tape lies on four generated people. `python docs/girths.py`"""

from pathlib import Path

import numpy as np

from lssd_learn.collections import People
from lssd_learn.collections.generated.measured import taped
from lssd_learn.shapes import Mesh
from lssd_learn.view.painter import paint, save_png

RADIUS = 0.006  # of the tape, in metres


def ring(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a tube around the closed polygon through points (h, 3)."""
    n, centre = len(points), points.mean(0)
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    out = points - centre
    side = np.cross(along, out)
    turns = np.linspace(0, 2 * np.pi, 6, endpoint=False)[:, None, None]
    out, side = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (np.cross(side, along), side))
    vertices = points + RADIUS * (np.cos(turns) * out + np.sin(turns) * side)
    j, i = (grid.ravel() for grid in np.meshgrid(np.arange(6), np.arange(n), indexing="ij"))
    a, b, c, d = j * n + i, j * n + (i + 1) % n, (j + 1) % 6 * n + i, (j + 1) % 6 * n + (i + 1) % n
    return vertices.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])


def main() -> None:
    people = People(n=60)
    bmi = people.parameters[:, -1] / people.parameters[:, 0] ** 2
    woman = people.sliders[:, people.slider_names.index("gender")] > 0.5
    chosen = [np.flatnonzero(some)[pick(bmi[some])] for some in (woman, ~woman) for pick in (np.argmin, np.argmax)]
    shapes, values = [], []
    for i in chosen:
        body, tapes = taped(dict(zip(people.slider_names, people.sliders[i].tolist(), strict=True)))
        vertices, faces = [body.vertices], [body.faces]
        for tape in tapes.values():
            more, around = ring(tape.points)
            faces.append(around + sum(map(len, vertices)))
            vertices.append(more)
        shapes.append(Mesh(np.concatenate(vertices), np.concatenate(faces)))
        values.append((np.arange(len(shapes[-1].vertices)) >= len(body.vertices)).astype(float))
    views = [paint(shapes, values, size=520, azimuth=a, limits=(-1.2, 1.2), colormap="coolwarm") for a in (25, 155)]
    width = min(view.shape[1] for view in views)
    save_png(np.concatenate([view[:, :width] for view in views]), Path(__file__).parent / "girths.png")


if __name__ == "__main__":
    main()
