"""`task=highlight_benchmark`: how well a comparison finds where groups are known to differ.

Two groups of bodies in eight poses differ in one parameter (`collection=changed`). What is highlighted on each body is
compared with the true change of area at the vertices, in the rest pose.
"""

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
from torch import Tensor
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.collections import Changed
from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.exploration import evidence, local_evidence
from lssd_learn.exploration.scores import area_under_curve, correlation, rank_correlation, strongest
from lssd_learn.latent import LatentSpace
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.view.coloured import add_picture
from lssd_learn.view.fields import Field, unit_of_change
from lssd_learn.view.highlights import highlight_chart
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE = "highlights.csv"

# Name → how many functions (None is all), method, and whether each vertex asks the function concentrated there.
ANSWERS: dict[str, tuple[int | None, str, bool]] = {
    "first function": (1, "difference", False),
    "two functions": (2, "difference", False),
    "four functions": (4, "difference", False),
    "all functions": (None, "difference", False),
    "all, at each vertex": (None, "difference", True),
    "ratio, first function": (1, "ratio", False),
    "ratio, all, at each vertex": (None, "ratio", True),
}
DEFAULT = "all, at each vertex"  # what `task=compare` shows


def run(pieces: Pieces, out: Path, epsilon: float = 1e-2, shown: int = 4) -> dict[str, float]:
    """Write highlights.csv and highlighted.png: the truth, and what the functions of each of `ANSWERS` say.

    Args:
        epsilon: of the method "ratio", see `cross_collection`.
        shown: bodies in the picture.

    Returns:
        auc and auc/lowest, of the vertices where the logarithm of the area changes by more than half its 99th
        percentile, as mean over the bodies and of the worst body; spearman and pearson, correlation with its size, as
        means: for what `task=compare` shows, and as <kind>/<answer>/auc of all. Vertices count by their areas.

    Raises:
        InputError: a collection whose change is not known; arguments out of range.
    """
    collection = pieces.pipeline.collection
    if not isinstance(collection, Changed):
        raise InputError("task=highlight_benchmark: expected collection=changed, of which the truth is known")
    check_positive("task.epsilon", epsilon)
    check_whole("task.shown", shown, 1)
    latent, _ = pieces.pipeline.latent, pieces.pipeline.bases
    operators = pieces.pipeline.operators(pieces.operators)
    truth = np.abs(collection.log_area_ratio)
    groups = list(collection.groups["size"])
    rows, fields = [], []
    few = np.linspace(0, len(collection) - 1, min(shown, len(collection))).round().astype(int).tolist()
    for c, kind in enumerate(pieces.operators):
        for name, (count, method, local) in ANSWERS.items():
            R = evidence(operators[:, c], groups, count, method, epsilon=epsilon)
            draw = local_evidence if local else sum_of_squares
            rows.append({"operator": kind, "answer": name, **_score(latent, R, draw, truth, f"{kind}, {name}")})
            values = [draw(latent, R, i).numpy() for i in few]
            title, unit = f"{kind}: {name}, AUC {rows[-1]['auc']:.3f}", unit_of_change(kind) if local else ""
            fields.append(Field.positive(name, title, values, unit=unit))
    known = {"change": collection.change, "others": collection.others, "n": len(collection) // 2, "keep": latent.keep}
    write_rows([known | row for row in rows], out / TABLE)

    true = Field.positive(
        "truth", f"{collection.change}: true |log area ratio|", [truth] * len(few), unit="log area ratio"
    )
    titles = [f"{groups[i]}\n{collection.groups['pose'][i]}" for i in few]
    figure = highlight_chart([collection[i] for i in few], titles, [true, *fields], collection.up)
    figure.savefig(out / "highlighted.png")
    with SummaryWriter(out / "tensorboard") as writer:
        add_picture(writer, "highlight_benchmark/highlighted", out / "highlighted.png")

    log.info("%s, %d bodies a group, other parameters %s", collection.change, len(groups) // 2, collection.others)
    log.info("  %-38s %6s %7s %9s %8s", "", "AUC", "lowest", "Spearman", "Pearson")
    for row in rows:
        scores = [row[key] for key in ("auc", "auc/lowest", "spearman", "pearson")]
        log.info("  %-38s %6.3f %7.3f %9.2f %8.2f", f"{row['operator']}: {row['answer']}", *scores)
    log.info("%s, highlighted.png", TABLE)
    first = next(row for row in rows if row["answer"] == DEFAULT)
    named = {f"{row['operator']}/{row['answer']}/auc": row["auc"] for row in rows}
    return {key: value for key, value in first.items() if isinstance(value, float)} | named


def sum_of_squares(latent: LatentSpace, R: Tensor, i: int) -> Tensor:
    """(V,) Σ (Φ_iY_iR)² over the columns of R: functions looked at as the paper does."""
    return latent.to_shape(R, i).square().sum(1)


def _score(latent: LatentSpace, R: Tensor, draw: Callable, truth: np.ndarray, name: str) -> dict[str, float]:
    found = []
    for i in track(range(len(latent)), name):
        field = draw(latent, R, i).numpy()
        mass = np.asarray(latent.eigenbasis(i).mass)
        related = (rank_correlation(field, truth, mass), correlation(field, truth, mass))
        found.append((area_under_curve(field, strongest(truth, mass), mass), *related))
    auc, spearman, pearson = np.array(found).T
    return {
        "auc": float(auc.mean()),
        "auc/lowest": float(auc.min()),
        "spearman": float(spearman.mean()),
        "pearson": float(pearson.mean()),
    }
