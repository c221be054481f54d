"""What `task=benchmark` times of our own, as work for the stopwatch. The peer's is in `peer.py`.

Imports stand inside: each process loads what its work needs and no more, so that its memory is the work's own.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np


def eigenbases(shapes: Sequence, k: int, laplacian: str):
    """The eigenbasis of each shape, Laplacian included; a lap a shape."""
    from lssd_learn.shapes import eigenbasis

    eigenbasis(shapes[-1], k, laplacian)
    for i, shape in enumerate(shapes):
        yield f"shape {i}"
        eigenbasis(shape, k, laplacian)
    yield None


def prepared(collection, k: int, laplacian: str, workers: int, folder: Path):
    """The shapes of a collection made or read, and their eigenbases computed and stored; nothing is known before.

    Args:
        folder: where there is room for them for the time being.
    """
    from lssd_learn.cache import Cache
    from lssd_learn.collections.eigenbases import eigenbases

    with TemporaryDirectory(dir=folder) as room:
        os.environ["LSSD_CACHE"] = room
        yield "eigenbases"
        eigenbases(collection, k, laplacian, Cache(), workers)
        yield None


def latent(bases: Sequence, network: Callable, size: int, keep: int):
    """Shapes in vertex correspondence to their network, that to its latent space and to the operators of all shapes.

    Args:
        network: bases → MapNetwork.

    Returns:
        see `spectra`.
    """
    from lssd_learn.latent import LatentSpace, MapNetwork

    LatentSpace.fit(MapNetwork.clique([bases[0], bases[1]]), size, keep)
    for _ in bases:  # verified against their checksums, and in the system's memory
        pass
    yield "network"
    made = network(bases)
    yield "space"
    space = LatentSpace.fit(made, size, keep)
    yield "operators"
    area, conformal = space.differences()
    yield None
    return spectra(area.numpy(), conformal.numpy())


def spectra(area: np.ndarray, conformal: np.ndarray) -> np.ndarray:
    """The eigenvalues (2, n, m−1) of operators (n, m, m), ascending: what two computations must agree in.

    Without the constant, which is the null direction of the conformal ones and rounding in some implementations.
    """
    return np.stack([np.sort(np.linalg.eigvals(D[:, 1:, 1:]).real, axis=1) for D in (area, conformal)])


def cached(pipeline, kinds: Sequence[str]):
    """The operators of a pipeline from its eigenbases, and again from the cache where the first lap left them."""
    from lssd_learn.cache import Cache
    from lssd_learn.collections.eigenbases import STAGE

    with TemporaryDirectory() as folder:
        # A cache of its own that knows the eigenbases and nothing later.
        (Path(folder) / STAGE).symlink_to(pipeline.cache.root / STAGE)
        os.environ["LSSD_CACHE"] = folder
        _ = pipeline.bases  # found and verified before the clock starts
        again = replace(pipeline, cache=Cache())
        yield "compute"
        pipeline.operators(kinds)
        yield "read"
        again.operators(kinds)
        yield None


def training(net: Callable, data: dict, epochs: int, learning_rate: float, seed: int):
    """`learning.fit` on the arguments `data` of a `ShapeData`.

    Returns:
        the validation error of the chosen epoch.
    """
    from lssd_learn.learning import ShapeData, fit

    with TemporaryDirectory() as folder:
        options = {"learning_rate": learning_rate, "seed": seed}
        fit(net, ShapeData(**data), epochs=1, out=Path(folder) / "warm", **options)
        shapes = ShapeData(**data)
        yield "fit"
        metrics = fit(net, shapes, epochs=epochs, out=Path(folder) / "timed", **options)
        yield None
        return metrics["validation/mse"]
