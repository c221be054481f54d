"""The page of a linear model of shape: surfaces that change along its terms, tables, where, chance, methods."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lssd_learn.exploration.models.answer import Answer
from lssd_learn.exploration.models.known import Asked
from lssd_learn.exploration.models.strata import Stratum
from lssd_learn.exploration.surfaces.found import Surfaces
from lssd_learn.view.fields import Field
from lssd_learn.view.model_files import mass, rows, shown_field
from lssd_learn.view.reports.blocks import folded, listed, paragraph, table, words
from lssd_learn.view.reports.charts import grid, histogram, scatter
from lssd_learn.view.reports.methods import Latent, chance, p_value, references
from lssd_learn.view.reports.page import Section, write_page
from lssd_learn.view.reports.stage import Stage
from lssd_learn.view.surfaces import move_fields, thumbnail, ways

MEANT = {
    "term": "what may explain shape; residuals are what no term explains",
    "df": "degrees of freedom: how many numbers the term has to fit",
    "SS": "sum of squares: how much of the differences between shapes goes with the term",
    "R²": "the same as a part of all differences: 0.10 is ten per cent",
    "F": "how much more a term explains than as many numbers without meaning would; about 1 is nothing",
    "Z": "how far F lies above what chance gives, in standard deviations; above 2 is rare",
    "p": "how often chance alone explains as much; the smaller, the less likely chance is the reason",
    "p smallest": "the least that p can be with so many permutations: no smaller one can come out",
    "p corrected": "p where several kinds of differences were looked at together",
    "what": "distance between two groups or of a standard deviation of a number, angle between two slopes, how much "
    "more one group varies",
}
SEEN = (
    "On the left a computed surface, on the right a real shape, {name}, whose mesh and fine detail (whatever is finer "
    "than {keep} functions see) the computed one borrows. The slider goes from two standard deviations below the mean "
    "to two "
    "above, or from group to group, and as far again beyond, which exaggerates. Other numbers are kept at their "
    "mean{kept}."
)
SCATTERED = (
    "Each point is a shape; near points are shapes that differ little. Rest the pointer on one, or touch it, for its "
    "name. Around each group its convex hull. At the ends of the axes, the surface two standard deviations from the "
    "mean."
)


@dataclass(frozen=True)
class Seen:
    """How the real shape of a page is seen.

    Attributes:
        name: of the shape.
        up: the axis that points up in it; None if unknown.
        azimuth: degrees from which it is seen first.
        picture: a PNG of the surfaces, for browsers without WebGL.
    """

    name: str
    up: str | None
    azimuth: float
    picture: bytes


def write_model_report(
    path: Path,
    found: Answer,
    asked: Asked,
    parts: Sequence[Stratum],
    latent: Latent,
    surfaces: Surfaces,
    seen: Seen,
    sums: str,
    blocks: str | None,
) -> None:
    """Write report.html of `task=model`.

    Args:
        path: of the file.
        found: what the formula tells.
        asked: the formula and its shapes.
        parts: its strata.
        latent: how the latent space was made.
        surfaces: of the same model.
        seen: how shapes are seen.
        sums: type of the sums of squares.
        blocks: name of the grouping of shapes that belong together.
    """
    lender, morphs = surfaces.lender, [*surfaces.morphs, *surfaces.components.values()]
    fields = [
        shown_field(kind, field, mass(lender.shape)) for kind, several in found.fields.items() for field in several
    ]
    copied = [Field(f.name, f.title, [f.values[0]] * 2, f.limits, f.colormap) for f in fields]
    kept = "".join(f", {factor} is {level}" for factor, level in surfaces.kept.items())
    stage = Stage(
        shapes=[lender.shape, lender.shape],
        names=["", seen.name],
        groups=["computed surface", "a real shape"],
        fields=[*copied, *move_fields(lender, morphs, copies=2)],
        up=seen.up,
        azimuth=seen.azimuth,
        picture=seen.picture,
        hint=SEEN.format(name=seen.name, keep=lender.functions.shape[1], kept=kept),
        ways=ways(lender, morphs, len(copied)),
    )
    design = asked.design
    sections = [
        Section("What explains shape", _numbers(found)),
        Section("Where", _where(rows(found.fields, mass(lender.shape)))),
        Section("Principal components", _components(found, asked, surfaces, seen)),
        Section("Could it be chance?", _histograms(found)),
        Section("Methods", [_methods(found, asked, parts, latent, sums, blocks), latent.read(), _references(blocks)]),
        Section("Files", [listed(FILES)]),
    ]
    write_page(
        path,
        title=f"What explains shape: {design.formula.strip()}",
        summary=_summary(found, len(asked.shapes)),
        stage=stage,
        sections=sections,
        footer=f"lssd_learn, task=model; {latent.shapes} shapes in the latent space, {len(asked.shapes)} in the model.",
    )


FILES = (
    "model.csv, pairwise.csv, scores.csv: the tables, and the scores of each shape",
    "fields/: every field as arrays of the same names in .npz and .ply, at the vertices of the real shape",
    "surfaces/: the mean surface and both ends of what the slider shows, as .ply and .glb",
    "fields.csv, fields.png, surfaces.png: the fields as a table, pictures",
    "provenance.json: the command, versions and inputs, to run this again",
)


def _summary(found: Answer, shapes: int) -> str:
    kind, model = next(iter(found.tables.items()))
    said = "; ".join(f"{row.term} explains {row.R2:.1%} (p {p_value(row.chance.p)})" for row in model.terms)
    return f"{shapes} shapes. Of their differences by {kind}: {said}."


def _numbers(found: Answer) -> list[str]:
    several = any("p corrected" in row for row in found.rows)
    columns = {"df": "df", "SS": "SS", "R2": "R²", "F": "F", "Z": "Z", "p": "p", "p smallest": "p smallest"}
    columns |= {"p corrected": "p corrected"} if several else {}
    lines = [[row["operator"], row["term"], *(_cell(row.get(key)) for key in columns)] for row in found.rows]
    meant = {name: MEANT[name] for name in ("term", *columns.values()) if name in MEANT}
    parts = [table(["differences", "term", *columns.values()], lines, 2), words(meant)]
    if found.pairs:
        keys = ("value", "Z", "p", "p corrected")
        lines = [
            [r["operator"], r["term"], r["what"], r["pair"], *(_cell(r.get(k)) for k in keys)] for r in found.pairs
        ]
        pairs = table(["differences", "term", "what", "pair", *keys], lines, 4)
        parts.append(folded("Groups and slopes in pairs", pairs + words({"what": MEANT["what"]})))
    return parts


def _where(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    if not rows:
        return [paragraph("No term has a field of its own.")]
    lines = [
        [str(row["operator"]), str(row["term"]), str(row["contrast"]), _cell(row["p anywhere"]),
         f"{row['share of area']:.1%}", _cell(row.get("of it false")), _cell(row.get("lowest %")),
         _cell(row.get("highest %"))]
        for row in rows
    ]  # fmt: skip
    header = ["differences", "term", "contrast", "p anywhere", "share of area", "of it false", "lowest %", "highest %"]
    return [
        listed([f"By {row['operator']}: {row['in words']}" for row in rows]),
        table(header, lines, 3),
        words({
            "p anywhere": "how often chance alone gives an effect as clear at any point of the surface",
            "share of area": "on which part of the surface the effect is clearer than chance anywhere is in 95 of 100 "
            "cases; "
            "only there are the fields coloured, elsewhere they are grey",
            "core": "the part of the surface where it is so, and the effect more than half as large as the largest",
            "of it false": "at most this part of that area is expected to be chance",
            "lowest %, highest %": "between which values the effect lies there; of area, by how many per cent it is "
            "larger, for a standard deviation of a number or between two groups",
        }),
    ]  # fmt: skip


def _components(found: Answer, asked: Asked, surfaces: Surfaces, seen: Seen) -> list[str]:
    factors = asked.design.factors
    labels: list[str | None] = [None] * len(asked.names)
    if factors:
        labels = [str(value) for value in asked.design.values[factors[0]]]
    figures = []
    for first in [name for name in found.scores if name.endswith(" PC1")]:
        second = first[:-1] + "2"
        if second in found.scores:
            kind = first.removesuffix(" PC1")
            total = found.tables[kind].rest["total"][1]
            parts = [float(np.square(found.scores[name]).sum()) / total for name in (first, second)]
            axes = (f"first component ({parts[0]:.0%})", f"second component ({parts[1]:.0%})")
            lines = [surfaces.components.get(name) for name in (first, second)]
            ends = (
                []
                if None in lines
                else [thumbnail(surfaces.lender, m, s, seen.up, seen.azimuth) for m in lines if m for s in (-1, 1)]
            )
            points = np.stack([found.scores[first], found.scores[second]], axis=1)
            title = f"{kind}{f', by {factors[0]}' if factors else ''}"
            figures.append(scatter(points, asked.names, labels, axes, title, ends))
    return [paragraph(SCATTERED, "hint"), grid(figures)]


def _histograms(found: Answer) -> list[str]:
    said = (
        "Grey-blue: F of each term where its residuals were given to other shapes at random. Red: F of the shapes as "
        "they "
        "are. p is the part of all that lies at the red line or beyond."
    )
    figures = [
        histogram(row.chance.found, f"{kind}: {row.term}", "F", f"p {p_value(row.chance.p)}")
        for kind, model in found.tables.items()
        for row in model.terms
    ]
    return [paragraph(said, "hint"), grid(figures)]


def _methods(
    found: Answer, asked: Asked, parts: Sequence[Stratum], latent: Latent, sums: str, blocks: str | None
) -> str:
    model = next(iter(found.tables.values()))
    often = chance(len(parts[-1].rows), parts[-1].exact)
    left = latent.shapes - len(asked.shapes)
    without = f" ({left} of {latent.shapes} were left out, of which not all was known)" if left else ""
    within = f" within and between the blocks given by {blocks} (Winkler et al. 2015)" if blocks else ""
    results = "; ".join(
        f"{row.term}, R² = {row.R2:.3f}, F({row.df}) = {row.F:.2f}, Z = {row.chance.Z:.2f}, p {p_value(row.chance.p)}"
        for row in model.terms
    )
    kind = next(iter(found.tables))
    text = (
        f"{latent.words()} Logarithms of these matrices (Arsigny et al. 2007) of {len(asked.shapes)} shapes{without} "
        f"were "
        f"explained by the linear model “{asked.design.formula.strip()}” with sums of squares of type {sums}. "
        f"Significance "
        f"comes from {often} of the residuals of the model without the term{within} (Freedman & Lane 1983; Collyer et "
        f"al. "
        f"2015). The same model was asked at each vertex of the surface; p-values there are corrected for all vertices "
        f"by "
        f"the largest statistic (Nichols & Holmes 2002). Surfaces are predictions of the same model for the "
        f"coordinates of "
        f"all shapes, carried to the latent shape and laid upon each other there by generalised Procrustes analysis "
        f"without scaling (Gower 1975). Result ({kind} differences): {results}."
    )
    return paragraph(text, "paste")


def _references(blocks: str | None) -> str:
    keys = ["differences", "latent", "maps", "logarithms", "rrpp", "residuals", "largest", "procrustes"]
    return folded("References", listed(references(keys + ["blocks"] * bool(blocks))))


def _cell(value: Any) -> str:
    return "" if value is None or value != value else f"{value:.3g}" if isinstance(value, float) else str(value)
