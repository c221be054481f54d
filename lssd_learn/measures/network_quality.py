"""`task=network_quality`: what computed maps cost the operators of a collection whose true maps are known."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.orthogonal import nearest_orthogonal
from lssd_learn.maps import VertexMaps
from lssd_learn.pieces import Pieces
from lssd_learn.view.errors import cumulative_chart
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE, PICTURE = "operator_errors.csv", "operator_errors.png"


def run(pieces: Pieces, out: Path, refine: Sequence[int] | None = None) -> dict[str, float]:
    """Compare the area operators of the run's network with those of the same network with the true maps.

    The error of a shape is ‖D − D*‖ over the root mean square of ‖D* − I‖ over the shapes, Frobenius norms, after one
    orthogonal transformation between the two latent bases. Writes operator_errors.csv, a row a shape, and a picture.

    Args:
        refine: first, last and step of Consistent ZoomOut, scored beside; None leaves it out.

    Returns:
        "shapes", "edges", and "error/{median,mean,worst}" and "refined/…" where it is asked for.

    Raises:
        InputError: a collection whose true maps nobody knows, maps=correspondence.
    """
    pipeline = pieces.pipeline
    if not pipeline.collection.vertex_maps:
        raise InputError("task=network_quality: expected a collection whose true maps are known: collection=remeshed")
    if not pipeline.computes_maps:
        raise InputError("task=network_quality: expected maps that are computed, such as maps=kernel_matching")
    true = replace(pipeline, maps=VertexMaps).latent
    found = {"error": pipeline.latent}
    network = pipeline.map_network()
    if refine is not None:
        refined = LatentSpace.fit(network.refine(*refine), pipeline.size, pipeline.size)
        found["refined"] = refined.with_keep(pipeline.keep)
    errors = {name: operator_errors(space.Y, true.Y) for name, space in found.items()}
    metrics = {"shapes": len(true), "edges": len(network.pairs())}
    for name, some in errors.items():
        numbers = np.median(some), some.mean(), some.max()
        metrics |= dict(zip((f"{name}/median", f"{name}/mean", f"{name}/worst"), numbers, strict=True))
        words = "operators" if name == "error" else f"{name}, they"
        log.info("%s are off by %.3f of their spread (median), %.3f (mean), %.3f (worst)", words, *numbers)
    columns = {"name": pipeline.collection.names} | {name: values.tolist() for name, values in errors.items()}
    write_columns(columns, out / TABLE)
    cumulative_chart(errors, "error of an operator / spread").savefig(out / PICTURE, dpi=150)
    log.info("%d shapes, %d edges: %s, %s", len(true), len(network.pairs()), out / TABLE, PICTURE)
    return {name: float(value) for name, value in metrics.items()}


def operator_errors(Y: Tensor, true: Tensor) -> np.ndarray:
    """(n,) ‖QᵀD_iQ − D*_i‖ / rms ‖D*_j − I‖ of the area operators of two families of latent bases (n, k, m).

    Q is the orthogonal matrix that minimises Σ ‖Y_i Q − Y*_i‖².
    """
    turned = Y @ nearest_orthogonal((Y.mT @ true).sum(0))
    D, expected = turned.mT @ turned, true.mT @ true
    spread = (expected - torch.eye(expected.shape[-1]).to(expected)).flatten(1).norm(dim=1).square().mean().sqrt()
    return ((D - expected).flatten(1).norm(dim=1) / spread).numpy()
