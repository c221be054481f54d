"""Draws docs/girths.png, where the tape lies on four generated people, and writes docs/measures.csv, how the
measures of 400 vary and depend on one another. `python docs/measures.py`"""

from pathlib import Path

import numpy as np

from lssd_learn.collections import People
from lssd_learn.collections.generated.measured import taped
from lssd_learn.models.measuring.picture import tube
from lssd_learn.shapes import Mesh
from lssd_learn.view.painter import paint, save_png
from lssd_learn.written import write_columns

DOCS = Path(__file__).parent
RADIUS = 0.006  # of the tape, in metres


def draw(people: People) -> None:
    """The slimmest and the heaviest woman and man, from the front and from behind."""
    bmi = people.parameters[:, -1] / people.parameters[:, 0] ** 2
    chosen = [np.flatnonzero(some)[pick(bmi[some])] for some in halves(people) for pick in (np.argmin, np.argmax)]
    shapes, values = [], []
    for i in chosen:
        body, tapes = taped(dict(zip(people.slider_names, people.sliders[i].tolist(), strict=True)))
        vertices, faces = [body.vertices], [body.faces]
        for tape in tapes.values():
            more, around = tube(tape.points, RADIUS)
            faces.append(around + sum(map(len, vertices)))
            vertices.append(more)
        shapes.append(Mesh(np.concatenate(vertices), np.concatenate(faces)))
        values.append((np.arange(len(shapes[-1].vertices)) >= len(body.vertices)).astype(float))
    views = [paint(shapes, values, size=420, azimuth=a, limits=(-1.2, 1.2), colormap="coolwarm") for a in (25, 155)]
    width = min(view.shape[1] for view in views)
    save_png(np.concatenate([view[:, :width] for view in views]), DOCS / "girths.png")


def halves(people: People) -> tuple[np.ndarray, np.ndarray]:
    """Masks of women and men."""
    woman = people.sliders[:, people.slider_names.index("gender")] > 0.5
    return woman, ~woman


def tell(people: People) -> None:
    """Mean and deviation of each measure of women and men, correlations, and what all others leave unknown."""
    measures, names = people.parameters, list(people.parameter_names)
    columns: dict[str, list] = {"measure": names}
    for who, some in zip(("women", "men"), halves(people), strict=True):
        columns |= {f"{who}_mean": measures[some].mean(0).tolist(), f"{who}_sd": measures[some].std(0).tolist()}
    scaled = np.log(measures) - np.log(measures).mean(0)
    lengths = [i for i, name in enumerate(names) if name not in ("area_m2", "volume_l")]
    left = []
    for i in range(len(names)):
        rest = scaled[:, [j for j in lengths if j != i]]
        residual = scaled[:, i] - rest @ np.linalg.lstsq(rest, scaled[:, i], rcond=None)[0]
        left.append(float(100 * residual.std()))
    correlations = np.corrcoef(scaled.T)
    columns |= {"sd_percent": (100 * scaled.std(0)).tolist(), "left_by_lengths_percent": left}
    columns |= {f"r_{name}": correlations[i].tolist() for i, name in enumerate(names)}
    write_columns(columns, DOCS / "measures.csv")


if __name__ == "__main__":
    everybody = People(n=400)
    draw(everybody)
    tell(everybody)
