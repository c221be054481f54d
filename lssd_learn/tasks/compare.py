"""`task=compare`: what tells groups of shapes apart, and where: pictures, coloured meshes, one page to look at."""

import logging
import re
from collections.abc import Sequence
from pathlib import Path

from torch import Tensor
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import ChosenGroups, choose_groups
from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.exploration.analysis import Analysis, analyse
from lssd_learn.exploration.blocks import Design
from lssd_learn.exploration.evidence import local_evidence
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.variability import METHODS
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.differences import DIFFERENCES
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Shape
from lssd_learn.unsaid import warn_of_blocks, warn_of_disagreement, warn_of_sides
from lssd_learn.view.coloured import add_picture, save_coloured, save_fields
from lssd_learn.view.embeddings import Panel, embedding_chart
from lssd_learn.view.fields import Field
from lssd_learn.view.highlights import highlight_chart
from lssd_learn.view.interactive import ensure_window, show
from lssd_learn.view.report import write_report
from lssd_learn.view.scenes import add_row

log = logging.getLogger(__name__)

MOST = 16  # shapes in pictures and on the page
FUNCTIONS = 2  # of those that tell groups apart, one by one

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


def run(
    pieces: Pieces,
    out: Path,
    group: str | None = None,
    labels: Sequence[str] = (),
    unlabelled: str | None = None,
    blocks: str | None = None,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    count: int = 2,
    permutations: int = 999,
    few: int | None = 5,
    shown: int = 2,
    azimuth: float = 20.0,
    interactive: bool = False,
) -> dict[str, float]:
    """Write report.html, highlighted.png, embedding.png, coloured shapes and a TensorBoard page; print the numbers.

    Args:
        group, labels, unlabelled, blocks: see `choose_groups`.
        method, mean, epsilon, count: of `cross_collection`.
        permutations: of `permutation_test`.
        few: labels a group in the semi-supervised comparison, see `few_labels_accuracy`; None leaves it out.
        shown: shapes that stand for each group in pictures.
        azimuth: degrees from which they are seen, see `paint`.
        interactive: open a window in the end in which the same shapes are turned by hand, see `view.interactive`.

    Returns:
        "shapes", "labelled" and the metrics of each `Analysis`, as area/p_value.

    Raises:
        InputError: as `choose_groups`; arguments out of range.
    """
    check_whole("task.shown", shown, 1)
    check_whole("task.permutations", permutations, 1)
    check_whole("task.count", count, 1, pieces.pipeline.keep)
    check_positive("task.epsilon", epsilon)
    if few is not None:
        check_whole("task.few", few, 1)
    if method not in METHODS:
        raise InputError(f"task.method={method}: expected one of {', '.join(METHODS)}")
    if interactive:
        ensure_window()
    pipeline = pieces.pipeline
    collection = pipeline.collection
    groups = choose_groups(collection, group, labels, unlabelled, blocks)
    design = None if blocks is None else Design.of_labels(groups.of, groups.blocks)  # before the long work
    latent, _ = pipeline.latent, pipeline.bases  # whoever asks for the operators gets missing eigenbases made too
    operators = pipeline.operators(pieces.operators)
    _warn(collection, operators, pieces.operators, groups, blocks)
    how = {"method": method, "mean": mean, "epsilon": epsilon, "count": count}
    found = [
        analyse(kind, latent, operators[:, c], groups, permutations=permutations, few=few, seed=pieces.seed, **how)
        for c, kind in enumerate(pieces.operators)
    ]

    chosen = _representatives(operators, groups, shown)
    shapes, titles = [collection[i] for i in chosen], _titles(collection, groups, chosen)
    fields = [field for analysis in found for field in _fields(analysis, latent, list(chosen))]
    names = [collection.names[int(i)] for i in groups.shapes]
    panels = [_panels(analysis, few) for analysis in found]
    pictures = {
        "highlighted": highlight_chart(shapes, titles, fields, collection.up, azimuth),
        "embedding": embedding_chart(panels, groups.of, names),
    }
    for name, figure in pictures.items():
        figure.savefig(out / f"{name}.png")
    _save_shapes(out / "shapes", collection, list(chosen), shapes, fields)
    with SummaryWriter(out / "tensorboard") as writer:
        for field in fields:
            add_row(writer, f"highlighted/{field.name}", shapes, collection.up, field.colours)
        for name in pictures:
            add_picture(writer, f"compare/{name}", out / f"{name}.png")

    several = f"{len(groups.labels)} groups"
    title = f"{groups.name}: {' against '.join(groups.labels) if len(groups.labels) < 4 else several}"
    header, rows = ["", *pieces.operators], _rows(found, groups)
    write_report(
        out / "report.html",
        title=title,
        summary=_summary(found, groups, design),
        shapes=shapes,
        names=[collection.names[i] for i in chosen],
        groups=list(chosen.values()),
        fields=fields,
        panels=[panel for row in panels for panel in row],
        points={"names": names, "labels": groups.of},
        header=header,
        rows=rows,
        notes=_notes(pieces.operators),
        footer=f"lssd_learn: {len(latent)} shapes in the latent space, operators of {latent.keep} functions",
        picture=(out / "highlighted.png").read_bytes(),
        up=collection.up,
        azimuth=azimuth,
    )
    _tell(title, header, rows)
    if design is not None:
        log.info("blocks by %s: %s", blocks, design)
    p_values = {analysis.kind: analysis.metrics["p_value"] for analysis in found}
    warn_of_disagreement(pieces, groups, p_values, permutations, method, epsilon)
    log.info(
        "report.html (open it in a browser), highlighted.png, embedding.png; coloured shapes, with values, in shapes/"
    )
    if interactive:
        show(shapes, [collection.names[i] for i in chosen], fields, collection.up)
    return {
        "shapes": len(groups.shapes),
        "labelled": sum(label is not None for label in groups.of),
        **{f"{a.kind}/{name}": value for a in found for name, value in a.metrics.items()},
        **{f"{a.kind}/size/{label}": size for a in found for label, size in a.sizes.items()},
    }


def _warn(
    collection: Collection, operators: Tensor, kinds: Sequence[str], groups: ChosenGroups, blocks: str | None
) -> None:
    """Of blocks that nobody named, and of what varies most and was not asked for."""
    asked = [name for name in (groups.name, blocks) if name is not None]
    if blocks is None:
        why = "p-values and accuracies take all shapes as independent"
        warn_of_blocks(collection, operators, "task.blocks", why, groups.shapes, asked)
    warn_of_sides(collection[groups.shapes], operators[groups.shapes], kinds, asked)


def _notes(kinds: Sequence[str]) -> list[str]:
    """What the numbers mean, for whatever differences there are; some only where they are asked for."""
    told = {kind: each for kind, each in DIFFERENCES.items() if kind in kinds or not each.asks}
    units = "".join(f"; by {kind} operators {each.unit}" for kind, each in told.items() if each.unit)
    tells = "; ".join(f"by {kind} operators, {each.tells}" for kind, each in told.items() if each.tells)
    return [WHERE.format(units), *NOTES, f"{SIZE}. {tells[:1].upper()}{tells[1:]}."]


def _representatives(operators, groups: ChosenGroups, shown: int) -> dict[int, str]:
    """Position in the collection → label of the shapes that stand for the groups, group by group."""
    shown = max(1, min(shown, MOST // len(groups.labels)))
    if len(groups.labels) > MOST:
        log.info("of %d groups the first %d are in the pictures", len(groups.labels), MOST)
    chosen = {}
    for label in groups.labels[:MOST]:
        members = groups.members(label)
        chosen |= {int(members[i]): label for i in representatives(operators[members], shown)}
    return chosen


def _fields(analysis: Analysis, latent: LatentSpace, chosen: Sequence[int]) -> list[Field]:
    """Where the groups differ, the functions that tell them apart, and the one that varies most, on chosen shapes."""
    kind, count = analysis.kind, min(FUNCTIONS, analysis.alpha.shape[1])

    def on_shapes(functions) -> list:
        return [latent.to_shape(functions, i).cpu().numpy() for i in chosen]

    local = [local_evidence(latent, analysis.region, i).cpu().numpy() for i in chosen]
    unit = "part of the area" if kind == "area" else "relative change"
    fields = [Field.positive(f"{kind}_region", f"{kind}: where the groups differ, and by how much", local, unit)]
    for j in range(count):
        number = f" {j + 1}" if count > 1 else ""
        title = f"{kind}: function{number} that tells the groups apart"
        fields.append(Field.signed(f"{kind}_function{number.strip()}", title, on_shapes(analysis.alpha[:, j])))
    title = f"{kind}: where shapes vary most, whatever the group"
    return [*fields, Field.squared(f"{kind}_global", title, on_shapes(analysis.varied[:, None]))]


def _panels(analysis: Analysis, few: int | None) -> list[Panel]:
    kind = analysis.kind
    found = {
        "the operators D": analysis.before,
        "with α suppressed": analysis.suppressed,
        "the features Dα": analysis.after,
        f"Dα, α from {few} labels a group": analysis.few,
    }
    return [Panel(e.points, e.ratios, f"{kind}: {title}") for title, e in found.items() if e is not None]


def _titles(collection: Collection, groups: ChosenGroups, chosen: dict[int, str]) -> list[str]:
    return [f"{label}\n{collection.names[i]}" for i, label in chosen.items()]


def _save_shapes(
    folder: Path, collection: Collection, chosen: Sequence[int], shapes: Sequence[Shape], fields: Sequence[Field]
) -> None:
    folder.mkdir(exist_ok=True)
    for i, (shape, number) in enumerate(zip(shapes, chosen, strict=True)):
        name, space = collection.names[number], collection.space(number)
        plain = re.sub(r"[^\w.-]", "_", name)  # a name may hold what a file name may not
        save_fields(shape, fields, i, folder / f"{plain}.vtp", space)
        for field in fields:
            for suffix in (".ply", ".glb"):
                path, values = folder / f"{plain}_{field.name}{suffix}", {field.name: field.values[i]}
                save_coloured(shape, field.colours(i), path, collection.up, values, space)


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


def _summary(found: Sequence[Analysis], groups: ChosenGroups, design: Design | None) -> str:
    sizes = ", ".join(f"{len(groups.members(label))} {label}" for label in groups.labels)
    unknown = sum(label is None for label in groups.of)
    without = f" and {unknown} of unknown group" if unknown else ""
    chance = ", ".join(f"{a.kind}: p = {a.metrics['p_value']:.3g}" for a in found)
    how = "" if design is None else f" Blocks: {design}."
    return f"{len(groups.shapes)} shapes: {sizes}{without}. Could the difference be chance? {chance}.{how}"


def _tell(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    log.info("%s", title)
    first = max(len(row[0]) for row in rows)
    for name, *cells in [header, *rows]:
        log.info("  %-*s %s", first, name, " ".join(f"{cell:>10}" for cell in cells))
