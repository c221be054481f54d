"""What a linear model of shape leaves: tables, fields as files for other programs, and a picture of them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.exploration.models.answer import Answer
from lssd_learn.exploration.models.points import PointField
from lssd_learn.exploration.models.words import in_words
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.writing import ply
from lssd_learn.view.fields import Field
from lssd_learn.view.highlights import highlight_chart
from lssd_learn.written import write_arrays, write_columns, write_rows

ARRAYS = ("effect", "low", "high", "statistic", "p", "p_enhanced", "false", "least", "shrunk")
LOGARITHMS = ("effect", "low", "high", "least", "shrunk")


def arrays(field: PointField) -> dict[str, np.ndarray]:
    """(V,) each, those that are logarithms as percent."""
    values = {name: np.asarray(getattr(field, name)) for name in ARRAYS}
    return {name: 100 * np.expm1(v) if name in LOGARITHMS else v for name, v in values.items()}


def file_name(kind: str, field: PointField) -> str:
    """Such as field_area_sex_m-f, of letters that all systems take."""
    said = " ".join(part for part in (kind, field.term, field.title.replace(" - ", "-")) if part)
    return "field_" + re.sub(r"[^\w.-]+", "_", said).strip("_")


def shown_field(kind: str, field: PointField, areas: ArrayLike) -> Field:
    """The effect in percent where it is significant; pale grey where it is not."""
    values = np.where(field.significant, arrays(field)["effect"], 0.0)
    title = f"{kind}: {field.term}{f', {field.title}' if field.title else ''}, % where p ≤ .05"
    return Field.signed(file_name(kind, field), title, [values], [np.asarray(areas)])


def write_answer(
    found: Answer,
    names: Sequence[str],
    shape: Shape,
    title: str,
    out: Path,
    up: str | None = None,
    azimuth: float = 20.0,
) -> None:
    """Write model.csv, pairwise.csv, scores.csv, fields.csv, fields.png and, of each field, an npz and a PLY with the
    same arrays at its vertices, into fields/; corrected.npz where a number was taken out of the operators.

    Args:
        found: what a formula tells.
        names: of the n shapes it was asked about.
        shape: at whose vertices the fields are.
        title: its name.
        out: the folder.
        up, azimuth: of `highlight_chart`.
    """
    write_rows(found.rows, out / "model.csv")
    write_rows(found.pairs, out / "pairwise.csv")
    write_columns({"name": names, **found.scores}, out / "scores.csv")
    write_rows(rows(found.fields, mass(shape)), out / "fields.csv")
    if found.corrected:
        write_arrays({"names": np.array(names), **found.corrected}, out / "corrected.npz")
    folder, drawn = out / "fields", []
    folder.mkdir(parents=True, exist_ok=True)
    for kind, several in found.fields.items():
        for field in several:
            values, seen = arrays(field), shown_field(kind, field, mass(shape))
            write_arrays(values, folder / f"{seen.name}.npz")
            (folder / f"{seen.name}.ply").write_bytes(ply(shape, seen.colours(0), values))
            drawn.append(seen)
    highlight_chart([shape], [title], drawn, up, azimuth).savefig(out / "fields.png")


def mass(shape: Shape) -> np.ndarray:
    """(V,) the area of each vertex; of a cloud all count the same."""
    return shape.vertex_areas if isinstance(shape, Mesh) else np.ones(len(shape.points))


def rows(fields: Mapping[str, Sequence[PointField]], mass: ArrayLike) -> list[dict[str, Any]]:
    """A row a field: the smallest p, how much of the area is significant, and more than half as large as the
    largest there, which part of it is so by chance, and between which percentages the effect lies there."""
    found: list[dict[str, Any]] = []
    area = np.asarray(mass, dtype=float) / np.sum(mass)
    for kind, several in fields.items():
        for field in several:
            there, values = field.significant, arrays(field)
            row: dict[str, Any] = {"operator": kind, "term": field.term, "contrast": field.title,
                                      "p anywhere": float(field.p.min()),
                                      "share of area": float(area[there].sum())}  # fmt: skip
            if there.any():
                row |= {"core": float(area[field.core].sum()),
                        "of it false": float(field.false[there].max()),
                        "lowest %": float(values["effect"][there].min()),
                        "highest %": float(values["effect"][there].max())}  # fmt: skip
            found.append(row | {"in words": in_words(kind, field, mass)})
    return found
