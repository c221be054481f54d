"""`task=operators`: stop at the operators and look at them."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.exploration import pca
from lssd_learn.latent.differences import DIFFERENCES
from lssd_learn.operators.vectors import shape_variables
from lssd_learn.pieces import Pieces
from lssd_learn.tasks.overview import write_overview
from lssd_learn.written import write_arrays, write_columns

log = logging.getLogger(__name__)

TOLD = 8  # eigenvalues in the log


def run(pieces: Pieces, out: Path) -> dict[str, float]:
    """Write operators.npz, latent.npz, shape_variables.csv, three pictures and a TensorBoard page; print the spectrum.

    operators.npz holds area, conformal and conformal_symmetric (n, m, m), spectrum (m,), pca (n, 2) and names (n,); and
    those of further kinds that there are, if they need no more than these, or the run asks for them.
    shape_variables.csv holds name and the logarithms of the run's operators, see `operators.vectors.shape_variables`.
    """
    pipeline = pieces.pipeline
    latent, _ = pipeline.latent, pipeline.bases  # whoever asks for the operators gets missing eigenbases made too
    tables = {}
    for kind, difference in DIFFERENCES.items():
        if kind in pieces.operators or not difference.asks:
            tables |= difference.tables(latent)
    operators = pipeline.operators(pieces.operators)
    embedding = pca(operators)
    arrays = {name: operators.numpy() for name, operators in tables.items()}
    arrays |= {"spectrum": latent.spectrum.numpy(), "pca": embedding.points.numpy(), "names": np.array(latent.names)}
    write_arrays(arrays, out / "operators.npz")
    latent.save(out / "latent.npz")
    variables = {name: x.tolist() for name, x in shape_variables(operators, pieces.operators).items()}
    write_columns({"name": latent.names, **variables}, out / "shape_variables.csv")
    write_overview(pieces, out, pictures=True)
    values = latent.spectrum.clamp(min=0).tolist()  # the first is a zero, and what rounding leaves of it
    told = " ".join(f"{value if value > 1e-9 * values[-1] else 0:.4g}" for value in values[:TOLD])
    log.info("latent spectrum: %s%s", told, " …" if len(values) > TOLD else "")
    log.info("%d shapes, operators of %d functions: operators.npz, latent.npz", len(latent), latent.keep)
    log.info(
        "%d shape variables, logarithms of operators, for programs of statistics: shape_variables.csv", len(variables)
    )
    log.info("pictures: collection.png, spectrum.png, pca.png")
    spread = (tables["area"] - tables["area"].mean(0)).flatten(1).norm(dim=1)
    return {
        "shapes": len(latent),
        "functions": latent.keep,
        "spectrum/first": float(latent.spectrum[min(1, latent.keep - 1)]),
        "spectrum/last": float(latent.spectrum[-1]),
        "energy/largest": float(latent.energy.max()),
        "spread/area": float(spread.square().mean().sqrt()),
        "pca/first": float(embedding.ratios[0]),
        "pca/second": float(embedding.ratios[1]),
    }
