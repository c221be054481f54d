"""`task=compare`: what tells groups of shapes apart, and where: pictures, coloured meshes, one page to look at."""

import logging
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from torch import Tensor
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import ChosenGroups, choose_groups
from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.exploration.analysis import Analysis, analyse
from lssd_learn.exploration.blocks import Design
from lssd_learn.exploration.evidence import local_evidence
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.surfaces.found import score_surfaces
from lssd_learn.exploration.variability import METHODS
from lssd_learn.latent import LatentSpace
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Shape
from lssd_learn.unsaid import warn_of_blocks, warn_of_disagreement, warn_of_sides
from lssd_learn.view.coloured import add_picture, save_coloured, save_fields
from lssd_learn.view.embeddings import Panel, embedding_chart
from lssd_learn.view.fields import Field, unit_of_change
from lssd_learn.view.highlights import highlight_chart
from lssd_learn.view.interactive import ensure_window, show
from lssd_learn.view.reports.compare import compare_stage, write_compare_report
from lssd_learn.view.reports.methods import Latent
from lssd_learn.view.scenes import add_row
from lssd_learn.view.surfaces import write_surfaces

log = logging.getLogger(__name__)

MOST = 16  # shapes in pictures and on the page
FUNCTIONS = 2  # of those that tell groups apart, one by one


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
    """Write report.html, highlighted.png, embedding.png, coloured shapes, mean surfaces and a TensorBoard page.

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

    shape, first = shapes[0], next(iter(chosen))
    scores = {f"{a.kind} PC{d + 1}": a.before.points[:, d].cpu().numpy() for a in found for d in (0, 1)}
    mirror = getattr(collection, "mirror", "auto")
    surfaces = score_surfaces(pipeline.whole, groups.shapes, scores, first, shape, mirror, pipeline.workers)
    surfaces = surfaces.with_groups(groups)
    write_surfaces(out / "surfaces", surfaces.lender, surfaces.mean, surfaces.morphs, collection.up)
    stage = compare_stage(surfaces, shapes, [collection.names[i] for i in chosen], list(chosen.values()), fields,
                          collection.up, azimuth, (out / "highlighted.png").read_bytes())  # fmt: skip
    title, header, rows = write_compare_report(
        out / "report.html", found, groups, design, Latent.of(pipeline, pieces.choices["network"], pieces.operators),
        surfaces, stage, names, few, permutations,
        np.array([float(pipeline.bases[int(i)].mass.sum()) for i in groups.shapes]),
    )  # fmt: skip
    _tell(title, header, rows)
    if design is not None:
        log.info("blocks by %s: %s", blocks, design)
    p_values = {analysis.kind: analysis.metrics["p_value"] for analysis in found}
    warn_of_disagreement(pieces, groups, p_values, permutations, method, epsilon)
    log.info(
        "report.html (open it in a browser), highlighted.png, embedding.png; coloured shapes in shapes/, surfaces/"
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
    areas = [np.asarray(latent.eigenbasis(i).mass) for i in chosen]
    title = f"{kind}: where the groups differ, and by how much"
    fields = [Field.positive(f"{kind}_region", title, local, areas, unit_of_change(kind))]
    for j in range(count):
        number = f" {j + 1}" if count > 1 else ""
        title = f"{kind}: function{number} that tells the groups apart"
        fields.append(Field.signed(f"{kind}_function{number.strip()}", title, on_shapes(analysis.alpha[:, j]), areas))
    title = f"{kind}: where shapes vary most, whatever the group"
    return [*fields, Field.squared(f"{kind}_global", title, on_shapes(analysis.varied[:, None]), areas)]


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


def _tell(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    log.info("%s", title)
    first = max(len(row[0]) for row in rows)
    for name, *cells in [header, *rows]:
        log.info("  %-*s %s", first, name, " ".join(f"{cell:>10}" for cell in cells))
