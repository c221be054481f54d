"""`task=stability`: does the latent basis stay what it is when shapes are added, and is the latent shape the average?

The paper's Figure `average_shape`. The plain consistent basis is the same one before it is made canonical.
"""

import logging
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration import change_of_basis, off_band, principal_angles
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, average_eigenbasis
from lssd_learn.studies.stability_chart import stability_chart
from lssd_learn.view.painter import paint
from lssd_learn.written import write_arrays

log = logging.getLogger(__name__)

PAINTED = 8  # shapes at most, the last of those that stay and all that join


@dataclass(frozen=True)
class _Average:
    """What a latent space of `full_k` functions a shape is beside the average shape.

    Attributes:
        true: (m,) the spectrum of the average shape.
        found: (m,) that of the latent space.
        basis: (m, m) the latent functions in the average shape's, Φ₀ᵀM̄Φ_iY_i, the mean over the shapes i.
    """

    true: np.ndarray
    found: np.ndarray
    basis: np.ndarray

    @property
    def errors(self) -> np.ndarray:
        """(m - 1,) relative errors of the spectrum; the first eigenvalue is zero."""
        return np.abs(self.found[1:] / self.true[1:] - 1)


def run(
    pieces: Pieces,
    out: Path,
    added: int = 1,
    band: int = 2,
    full_k: int | None = 400,
    full_size: int = 320,
    functions: int = 50,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write stability.png and matrices.npz, and print by how much the bases turn.

    Args:
        added: the last so many shapes of the collection are those that join.
        band: changes of basis may spread over so many neighbours on either side.
        full_k: eigenfunctions a shape for the comparison with the average shape; null leaves that out, as does a
            collection without common faces.
        full_size: consistent functions there.
        functions: of these, the lowest, which are compared.
        azimuth: degrees from which the shapes are seen.

    Returns:
        "canonical/off_band", "canonical/off_diagonal" and "canonical/angle" (the largest between the two spans, in
        degrees), the same of "plain", and "ratio/off_band", plain over canonical; "average/spectrum" (largest relative
        error), "average/spectrum_mean", "average/off_band", "average/off_diagonal".

    Raises:
        InputError: an argument out of range.
    """
    pipeline = pieces.pipeline
    n = len(pipeline.collection)
    check_whole("task.added", added, 1, max(n - 2, 0))
    check_whole("task.band", band, 0)
    if full_k is not None:
        check_whole("task.functions", functions, 2, full_size)
        check_whole("task.full_size", full_size, 2, full_k)
    if pipeline.fitted is not None:
        raise InputError("data.protocol: expected transductive; this task chooses itself what is fitted to what")
    before = replace(pipeline, collection=pipeline.collection[: n - added])
    matrices, found = {}, {}
    for kind in ("plain", "canonical"):
        Y, Z = _basis(before, kind), _basis(pipeline, kind)[: n - added]
        T = change_of_basis(Y, Z).numpy()
        matrices[kind] = T
        found |= {f"{kind}/off_band": off_band(T, band), f"{kind}/off_diagonal": off_band(T)}
        found[f"{kind}/angle"] = math.degrees(float(principal_angles(Y, Z)[0]))
    for part in ("off_band", "off_diagonal"):
        found[f"ratio/{part}"] = found[f"plain/{part}"] / found[f"canonical/{part}"]

    spectra = {"latent shape": pipeline.latent.spectrum.numpy()}
    average = None if full_k is None else _average(pipeline, full_k, full_size, functions)
    if average is not None:
        matrices["average"] = average.basis
        spectra = {"average shape": average.true, f"latent shape, k = {full_k}": average.found}
        found |= {"average/spectrum": float(average.errors.max())}
        found |= {"average/spectrum_mean": float(average.errors.mean())}
        found |= {"average/off_band": off_band(average.basis, band), "average/off_diagonal": off_band(average.basis)}
    kept = {**matrices, **{name.replace(" ", "_"): s for name, s in spectra.items()}}
    write_arrays(kept, out / "matrices.npz")
    _picture(pipeline, added, matrices, spectra, azimuth).savefig(out / "stability.png")
    _tell(found, n - added, added, band, functions)
    return {"shapes": n, "added": added, **found}


def _basis(pipeline: Pipeline, kind: str) -> Tensor:
    """(n, k, keep) the canonical basis, or the plain one: canonical is plain times an orthogonal U."""
    if kind == "canonical":
        return pipeline.latent.Y
    whole = pipeline.with_keep(pipeline.size).latent
    return (whole.Y @ whole.U.T)[:, :, : pipeline.keep]


def _average(pipeline: Pipeline, k: int, size: int, functions: int) -> _Average | None:
    kinds = {basis.connectivity for basis in pipeline.bases}
    if len(kinds) > 1 or None in kinds:
        log.info("the average shape is left out: the shapes are not all in vertex correspondence")
        return None
    collection, vertices = pipeline.collection, len(pipeline.bases[0].mass)
    if k >= vertices:
        raise InputError(f"task.full_k={k}: expected fewer than the {vertices:,} vertices of a shape")
    true = average_eigenbasis(collection, functions, pipeline.laplacian)
    latent = replace(pipeline, k=k, size=size, keep=functions).latent
    weighted = torch.from_numpy(true.evecs * true.mass[:, None]).T
    carried = [weighted @ latent.to_shape(torch.eye(functions), i) for i in range(len(collection))]
    return _Average(true.evals, latent.spectrum.numpy(), torch.stack(carried).mean(0).numpy())


def _picture(pipeline: Pipeline, added: int, matrices: dict, spectra: dict, azimuth: float):
    collection = pipeline.collection
    n = len(collection)
    shown = range(max(0, n - max(PAINTED, added + 1)), n)[-max(PAINTED, added + 1) :]
    shapes = [collection[i] for i in shown]
    size = 300 if isinstance(shapes[0], Mesh) else 260
    image = paint(shapes, up=collection.up or "y", azimuth=azimuth, elevation=0, size=size)
    titles = [f"{collection.names[i]}{', added' if i >= n - added else ''}" for i in shown]
    long = {
        "plain": "change of the plain basis",
        "canonical": "change of the canonical basis",
        "average": "latent in average functions",
    }
    return stability_chart(image, titles, {long[name]: matrix for name, matrix in matrices.items()}, spectra)


def _tell(found: dict[str, float], before: int, added: int, band: int, functions: int) -> None:
    log.info("%d shapes, and %d more: energy of the change of basis off the diagonal", before, added)
    for kind in ("plain", "canonical"):
        off, strict, angle = (found[f"{kind}/{name}"] for name in ("off_band", "off_diagonal", "angle"))
        log.info("  %-9s %.4f off |i − j| ≤ %d, %.4f in all; spans at %.1f°", kind, off, band, strict, angle)
    log.info("  canonical: %.1f times less off the band", found["ratio/off_band"])
    if "average/spectrum" in found:
        worst, off = found["average/spectrum"], found["average/off_band"]
        log.info("average shape: %d eigenvalues within %.2f %%, energy off the band %.4f", functions, 100 * worst, off)
    log.info("stability.png, matrices.npz")
