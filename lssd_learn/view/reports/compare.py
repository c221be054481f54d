"""The page of a comparison of groups: where they differ, their mean surfaces, how well they are told apart, methods."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.stats import f_oneway

from lssd_learn.collections.groups import ChosenGroups
from lssd_learn.exploration.analysis import Analysis
from lssd_learn.exploration.blocks import Design
from lssd_learn.exploration.surfaces.found import Surfaces
from lssd_learn.latent.differences import DIFFERENCES
from lssd_learn.shapes import Shape
from lssd_learn.view.fields import Field
from lssd_learn.view.reports.blocks import folded, listed, paragraph, table
from lssd_learn.view.reports.charts import confusion, grid, histogram, scatter
from lssd_learn.view.reports.methods import Latent, chance, p_value, references
from lssd_learn.view.reports.page import Section, write_page
from lssd_learn.view.reports.stage import Stage
from lssd_learn.view.surfaces import move_fields, thumbnail, ways

LEVEL = 0.05  # of p, below which groups differ in size
WHERE = (
    "Functions on the latent shape are carried to each shape. Where the groups differ: by how much, at each vertex{}. "
    "The functions α that tell the groups apart best, one by one, are parts of it; as a whole the sign of a function "
    "means nothing."
)
NOTES = (
    "Silhouette: 1 is groups far apart, 0 or less is groups that overlap. That of the features Dα has seen the labels. "
    "Held out, the function is found again without the label of the shape that is asked about. With few labels it "
    "comes from the labelled few alone, and the others are asked about. With α suppressed the operators no longer "
    "differ in the functions α.",
    "Permutation test: the part of random groups that are as far apart, the function found anew for each; the smallest "
    "there could be stands beside it.",
    "Stability: the correlation, on each shape, of the field with the one found without the label of that shape.",
    "With task.blocks, labels are permuted and shapes left out by whole blocks, or permuted within blocks of several "
    "groups; the nearest shape is then one of another block. Where a block has several groups, functions, fields and "
    "features compare its shapes with each other alone.",
)
SIZE = "Size there: mean of αᵀDα in a group, 1 as in the mean of the collection"


SEEN = (
    "Real shapes and, first, a computed surface: the mean of a group, or what goes with a principal component, on the "
    "mesh "
    "of {name}, which lends it what is finer than {keep} functions see. The slider goes from group to group, or from "
    "two "
    "standard deviations below the mean to two above, and as far again beyond, which exaggerates."
)
SCATTERED = (
    "Each point is a shape; near points are shapes that differ little. Rest the pointer on one, or touch it, for its "
    "name. Around each group its convex hull."
)
FILES = (
    "shapes/: the shapes of this page with all fields, as arrays of the same names in .vtp and .ply, in colours as "
    ".glb",
    "surfaces/: the mean surface of all, and those of the groups, as .ply and .glb",
    "highlighted.png, embedding.png: pictures",
    "metrics.json: all numbers; provenance.json: the command, versions and inputs, to run this again",
)


def compare_stage(
    surfaces: Surfaces,
    shapes: Sequence[Shape],
    names: Sequence[str],
    labels: Sequence[str],
    fields: Sequence[Field],
    up: str | None,
    azimuth: float,
    picture: bytes,
) -> Stage:
    """What is seen: a computed surface, and shapes that stand for the groups.

    Args:
        surfaces: of the groups, on the mesh of the first shape.
        shapes, names, labels: of the shapes that stand for the groups.
        fields: on these.
        up, azimuth, picture: of a `Stage`.
    """
    lender, morphs = surfaces.lender, [*surfaces.morphs, *surfaces.components.values()]
    first = [Field(f.name, f.title, [f.values[0], *f.values], f.limits, f.colormap) for f in fields]
    blank = [np.zeros(len(shape.points)) for shape in shapes[1:]]
    moving = [
        Field(f.name, f.title, [*f.values, *blank], f.limits, f.colormap) for f in move_fields(lender, morphs, copies=2)
    ]
    return Stage(
        shapes=[lender.shape, *shapes],
        names=["", *names],
        groups=["computed surface", *labels],
        fields=[*first, *moving],
        up=up,
        azimuth=azimuth,
        picture=picture,
        hint=SEEN.format(name=names[0], keep=lender.functions.shape[1]),
        ways=ways(lender, morphs, len(first)),
    )


def write_compare_report(
    path: Path,
    found: Sequence[Analysis],
    groups: ChosenGroups,
    design: Design | None,
    latent: Latent,
    surfaces: Surfaces,
    stage: Stage,
    names: Sequence[str],
    few: int | None,
    permutations: int,
    areas: Float[np.ndarray, " n"],
) -> tuple[str, list[str], list[list[str]]]:
    """Write report.html of `task=compare`.

    Args:
        path: of the file.
        found: what each kind of operator tells.
        groups: that were compared.
        design: of blocks, None without.
        latent: how the latent space was made.
        surfaces: of the groups.
        stage: see `compare_stage`.
        names: of the shapes of `groups`.
        few: labels a group in the semi-supervised comparison.
        permutations: as asked for.
        areas: of the shapes of `groups`.

    Returns:
        The title, and the head and rows of the table of numbers.
    """
    several = f"{len(groups.labels)} groups"
    title = f"{groups.name}: {' against '.join(groups.labels) if len(groups.labels) < 4 else several}"
    kinds = [a.kind for a in found]
    header, rows = ["", *kinds], _rows(found, groups)
    taken = [confusion(a.taken, groups.labels, f"{a.kind}: which group a shape is taken for, held out") for a in found]
    tests = [
        histogram(
            np.concatenate([[a.test.statistic], a.test.permuted.cpu().numpy()]), f"{a.kind}: random groups",
            "how far groups are apart, over how far shapes of one", f"p {p_value(a.test.p_value)}",
        )
        for a in found
    ]  # fmt: skip
    said = (
        "Rows are what shapes are, columns what the nearest other shape is, the function that tells groups apart found "
        "without them: on the diagonal are those told right."
    )
    chances = (
        "Grey-blue: how far apart groups of the same sizes are that were drawn at random, the best function found anew "
        "for each. Red: the groups as they are. p is the part of all that lies at the red line or beyond."
    )
    write_page(
        path,
        title=title,
        summary=f"{_summary(found, groups, design)}{size_words(areas, groups)}",
        stage=stage,
        sections=[
            Section("Numbers", [table(header, rows), *(paragraph(note, "note") for note in _notes(kinds))]),
            Section("Told apart?", [paragraph(said, "hint"), grid(taken)]),
            Section("Could it be chance?", [paragraph(chances, "hint"), grid(tests)]),
            Section("Principal components", _components(found, groups, surfaces, stage, names, few)),
            Section(
                "Methods",
                [paragraph(_methods(found, groups, design, latent, permutations), "paste"), latent.read(), REFERENCES],
            ),
            Section("Files", [listed(FILES)]),
        ],
        footer=f"lssd_learn, task=compare; {latent.shapes} shapes, operators of {latent.keep} functions",
    )
    return title, header, rows


REFERENCES = folded("References", listed(references(["differences", "latent", "maps", "procrustes"])))


def _components(
    found: Sequence[Analysis],
    groups: ChosenGroups,
    surfaces: Surfaces,
    stage: Stage,
    names: Sequence[str],
    few: int | None,
) -> list[str]:
    figures = []
    for a in found:
        panels = {
            "the operators D": a.before,
            "with α suppressed": a.suppressed,
            "the features Dα": a.after,
            f"Dα, α from {few} labels a group": a.few,
        }
        for what, e in panels.items():
            if e is not None:
                parts = [float(ratio) for ratio in e.ratios[:2]]
                axes = (f"first component ({parts[0]:.0%})", f"second component ({parts[1]:.0%})")
                lines = [surfaces.components.get(f"{a.kind} PC{d}") for d in (1, 2)] if e is a.before else []
                how = {"up": stage.up, "azimuth": stage.azimuth}
                ends = [thumbnail(surfaces.lender, m, s, **how) for m in lines if m for s in (-1, 1)]
                points = e.points[:, :2].cpu().numpy()
                ends = ends if len(ends) == 4 else []
                figures.append(scatter(points, names, groups.of, axes, f"{a.kind}: {what}", ends))
    return [paragraph(SCATTERED, "hint"), grid(figures)]


def _methods(
    found: Sequence[Analysis], groups: ChosenGroups, design: Design | None, latent: Latent, permutations: int
) -> str:
    sizes = ", ".join(f"{len(groups.members(label))} {label}" for label in groups.labels)
    often = chance(len(found[0].test.permuted) + 1, found[0].test.exact)
    within = "" if design is None else f", labels permuted within or between blocks ({design})"
    results = "; ".join(
        f"{a.kind}, p {p_value(a.test.p_value)}, {a.metrics['accuracy/after']:.0%} of the shapes told right when held "
        f"out"
        for a in found
    )
    return (
        f"{latent.words()} Groups by {groups.name} ({sizes}) were compared by the functions on the latent shape that "
        f"tell "
        f"them apart best, with {often} of the labels{within}, the functions found anew for each. Mean surfaces are "
        f"those "
        f"of the coordinates of all shapes, carried to the latent shape and laid upon each other there by generalised "
        f"Procrustes analysis without scaling (Gower 1975). Result: {results}."
    )


def _notes(kinds: Sequence[str]) -> list[str]:
    """What the numbers mean, for whatever differences there are; some only where they are asked for."""
    told = {kind: each for kind, each in DIFFERENCES.items() if kind in kinds or not each.asks}
    units = "".join(f"; by {kind} operators {each.unit}" for kind, each in told.items() if each.unit)
    tells = "; ".join(f"by {kind} operators, {each.tells}" for kind, each in told.items() if each.tells)
    return [WHERE.format(units), *NOTES, f"{SIZE}. {tells[:1].upper()}{tells[1:]}."]


def _rows(found: Sequence[Analysis], groups: ChosenGroups) -> list[list[str]]:
    """The table of numbers: what it is, and a cell each analysis."""
    lines = {
        "silhouette of the operators": ("silhouette/before", "{:.2f}"),
        "silhouette with α suppressed": ("silhouette/suppressed", "{:.2f}"),
        "silhouette of the features Dα": ("silhouette/after", "{:.2f}"),
        "right by the nearest shape, operators": ("accuracy/before", "{:.0%}"),
        "right by the nearest shape, Dα held out": ("accuracy/after", "{:.0%}"),
        "right by the nearest labelled shape, few labels": ("accuracy/few", "{:.0%}"),
        "permutation test, p": ("p_value", "{:.3g}"),
        "the smallest p there could be": ("p_value/smallest", "{:.2g}"),
        "stability of the field, mean": ("stability", "{:.2f}"),
        "stability of the field, lowest": ("stability/lowest", "{:.2f}"),
    }
    sizes = [[f"size there, {label}", *(f"{a.sizes[label]:.3f}" for a in found)] for label in groups.labels]
    there = {title: line for title, line in lines.items() if all(line[0] in a.metrics for a in found)}
    return [[title, *(form.format(a.metrics[name]) for a in found)] for title, (name, form) in there.items()] + sizes


def size_words(areas: Float[np.ndarray, " n"], groups: ChosenGroups) -> str:
    """Where groups differ in total area, by an analysis of variance of its logarithm, that they do; else ""."""
    labels = np.array([str(label) for label in groups.of])
    parts = {label: areas[labels == label] for label in groups.labels}
    if min(map(len, parts.values())) < 2 or np.ptp(areas) <= 1e-9 * areas.max():
        return ""
    p = float(f_oneway(*(np.log(part) for part in parts.values())).pvalue)
    if not p <= LEVEL:
        return ""
    means = ", ".join(f"{label} {np.exp(np.log(part).mean()):.3g}" for label, part in parts.items())
    return (
        f" The groups differ in size (total area: {means}; p {p_value(p)}): what is shown is size and shape together. "
        f"For shape alone bring all to one area (collection.normalise_area=true of a folder), and look at both."
    )


def _summary(found: Sequence[Analysis], groups: ChosenGroups, design: Design | None) -> str:
    sizes = ", ".join(f"{len(groups.members(label))} {label}" for label in groups.labels)
    unknown = sum(label is None for label in groups.of)
    without = f" and {unknown} of unknown group" if unknown else ""
    chance = ", ".join(f"{a.kind}: p = {a.metrics['p_value']:.3g}" for a in found)
    how = "" if design is None else f" Blocks: {design}."
    return f"{len(groups.shapes)} shapes: {sizes}{without}. Could the difference be chance? {chance}.{how}"
