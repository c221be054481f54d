"""`task=model`: what a formula explains of shapes, how sure that is, and where."""

import logging
from pathlib import Path

from lssd_learn.errors import check_whole
from lssd_learn.exploration.models import table
from lssd_learn.exploration.models.allometry import ensure_number
from lssd_learn.exploration.models.answer import answer
from lssd_learn.exploration.models.clusters import Cells
from lssd_learn.exploration.models.known import ask
from lssd_learn.exploration.models.strata import ensure_testable, strata
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.surfaces.found import score_surfaces
from lssd_learn.pieces import Pieces
from lssd_learn.view.model_files import write_answer
from lssd_learn.view.reports.methods import Latent
from lssd_learn.view.reports.model import Seen, write_model_report
from lssd_learn.view.surfaces import surface_chart, write_surfaces

log = logging.getLogger(__name__)


def run(
    pieces: Pieces,
    out: Path,
    formula: str,
    blocks: str | None = None,
    sums: str = "I",
    permutations: int = 999,
    without: str | None = None,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write report.html, model.csv, pairwise.csv, scores.csv, fields.csv, fields.png, fields/, surfaces.png, surfaces/.

    Args:
        formula: the columns that shapes are explained by, see `design`, such as "~ log(size) + sex".
        blocks: a grouping of shapes that belong together, see `strata`.
        sums: type of the sums of squares in model.csv, I, II or III.
        permutations: how many; where there are no more than that, each is taken once.
        without: a number of the formula, such as log(size), that is taken out of the operators: corrected.npz.
        azimuth: degrees from which the shape is seen, see `paint`.

    Returns:
        "shapes" and the metrics of the `Answer`.

    Raises:
        InputError: as `ask`, `strata`, `model_table` and `without`; arguments out of range.
    """
    check_whole("task.permutations", permutations, 1)
    pipeline, kinds = pieces.pipeline, pieces.operators
    collection = pipeline.collection
    asked = ask(collection, formula, blocks)
    parts = strata(asked.design, asked.blocks, blocks or "", permutations, pieces.seed)
    ensure_testable(asked.design, parts, sums)
    if without is not None:
        ensure_number(asked.design, without)
    latent, _ = pipeline.latent, pipeline.bases  # whoever asks for the operators gets missing eigenbases made too
    operators = pipeline.operators(kinds)[asked.shapes]
    shown = int(asked.shapes[representatives(operators)[0]])
    found = answer(latent, operators, kinds, asked, parts, sums, shown, Cells.of(collection[shown]), without)

    shape, name, up = collection[shown], collection.names[shown], collection.up
    write_answer(found, asked.names, shape, name, out, up, azimuth)
    mirror = getattr(collection, "mirror", "auto")
    scores, workers = found.components, pipeline.workers
    surfaces = score_surfaces(pipeline.whole, asked.shapes, scores, shown, shape, mirror, workers)
    surfaces = surfaces.with_model(asked, parts, shown)
    write_surfaces(out / "surfaces", surfaces.lender, surfaces.mean, surfaces.morphs, up)
    lines = [*surfaces.morphs, *surfaces.components.values()]
    surface_chart(surfaces.lender, lines, up, azimuth).savefig(out / "surfaces.png")
    seen = Seen(name, up, azimuth, (out / "surfaces.png").read_bytes())
    latent_words = Latent.of(pipeline, pieces.choices["network"], kinds)
    write_model_report(out / "report.html", found, asked, parts, latent_words, surfaces, seen, sums, blocks)
    log.info("\n%s", "\n".join(table.lines(found.rows)))
    files = "model.csv, pairwise.csv, scores.csv, fields.csv, fields.png, fields/, surfaces.png, surfaces/"
    log.info("%d shapes: report.html (open it in a browser), %s", len(asked.shapes), files)
    return {"shapes": len(asked.shapes), **found.metrics}
