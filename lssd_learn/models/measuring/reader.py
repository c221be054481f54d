"""The reader of body measures: a few bodies to map scans to, a latent space, and a ridge on logarithms of operators."""

import io
import os
import uuid
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.cache import Cache
from lssd_learn.collections import AtHand, Collection, eigenbases
from lssd_learn.errors import InputError, reading
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.differences import stack_differences
from lssd_learn.latent.storage import TENSORS
from lssd_learn.latent.strangers import push_strangers
from lssd_learn.maps.auto import AutoMaps
from lssd_learn.models.measuring.features import Features
from lssd_learn.models.measuring.units import find_unit, in_metres
from lssd_learn.models.unlike import unlike
from lssd_learn.shapes import Eigenbasis, Mesh, Shape

FORMAT = 1


@dataclass(frozen=True, eq=False)
class Reading:
    """What is read of one scan.

    Attributes:
        unit: of the scan.
        values, low, high: (p,) each measure, and the interval that holds with the reader's `level`.
        unlike: how far from all bodies of the reader, 1 is the farthest that these are from each other.
        quality: of the map that it was read through, in [0, 1].
    """

    unit: str
    values: Float[np.ndarray, " p"]
    low: Float[np.ndarray, " p"]
    high: Float[np.ndarray, " p"]
    unlike: float
    quality: float


@dataclass(frozen=True, eq=False)
class BodyReader:
    """Reads the measures of scans of people, in any pose and however they lie.

    Attributes:
        space: of the reference bodies, with their eigenbases.
        vertices: (r, V, 3) of these, in metres; faces (F, 3).
        operators: which differences are read.
        features: how they are made of operators and frequencies.
        centre: (d,) of the features of scans, weights (d, p), mean (p,) of the logarithms of the measures.
        widths: (p,) of the intervals, in logarithms, and `level`, the probability that they hold with.
        names: p measures, see `MEASURES`.
        farthest: the largest `unlike` of a body that is to be read.
    """

    space: LatentSpace
    vertices: Float[np.ndarray, "r V 3"]
    faces: Int[np.ndarray, "F 3"]
    operators: Sequence[str]
    features: Features
    centre: Float[np.ndarray, " d"]
    weights: Float[np.ndarray, "d p"]
    mean: Float[np.ndarray, " p"]
    widths: Float[np.ndarray, " p"]
    names: Sequence[str]
    level: float = 0.9
    farthest: float = 1.5
    bodies: Collection = field(init=False, repr=False)

    def __post_init__(self):
        bodies = AtHand([Mesh(vertices, self.faces) for vertices in self.vertices])
        object.__setattr__(self, "bodies", bodies)

    def read(self, shape: Shape, unit: str = "auto", name: str = "scan", cache: Cache | None = None) -> Reading:
        """The measures of one scan.

        Args:
            shape: a mesh or a cloud, lying anyhow.
            unit: of its coordinates: m, cm, mm, or auto, which finds out.
            name: of it, for errors.
            cache: where its eigenbasis is kept.

        Raises:
            InputError: it is of no grown-up's size, is unlike the reader's bodies, or no map to one can be trusted.
        """
        try:
            unit = find_unit(shape, unit)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        scans = AtHand([in_metres(shape, unit)])
        scans.names = [name]
        operators, evals, quality, level = self.push(scans, cache)
        beyond = float(unlike(operators, stack_differences(self.space, self.operators))[1][0])
        if beyond > self.farthest:
            raise InputError(
                f"{name}: expected a whole body of a grown-up, but it is {beyond:.2g} times as far from the nearest as "
                f"any of these is from another (up to {self.farthest:.2g} is read)"
            )
        if quality[0] < level:
            raise InputError(
                f"{name}: expected a whole body of a grown-up, but no map to one can be trusted (quality "
                f"{quality[0]:.2f} of {level:g})"
            )
        found = self.predict(self.features(operators, evals))[0]
        low, high = found * np.exp(-self.widths), found * np.exp(self.widths)
        return Reading(unit, found, low, high, beyond, float(quality[0]))

    def push(
        self, scans: Collection, cache: Cache | None = None
    ) -> tuple[Float[Tensor, "n channels m m"], Float[Tensor, "n k"], Float[np.ndarray, " n"], float]:
        """Operators (n, channels, m, m) and frequencies (n, k) of scans in metres, the qualities (n,) of the maps they
        came by, and the level from which these can be trusted."""
        k, r = self.space.evals.shape[1], len(self.space)
        bases = eigenbases(scans, k, "auto", cache, 1)
        came = push_strangers(
            self.space, self.bodies, scans, bases, AutoMaps, 1, r, cache, 1, ["AutoMaps", AutoMaps.version]
        )
        quality = np.ones(len(scans)) if came.quality is None else came.quality
        quality = np.where(np.isnan(quality), ~came.doubtful, quality)
        return stack_differences(came.space, self.operators), came.space.evals, quality, came.level

    def predict(self, features: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "n p"]:
        """(n, p) the measures of scans with these `features` (n, d)."""
        return np.exp(self.mean + (features - self.centre) @ self.weights)

    def save(self, path: str | Path) -> Path:
        """Write it as one .npz file, the same bytes for the same reader."""
        path, bases = Path(path), [self.space.eigenbasis(i) for i in range(len(self.space))]
        arrays = {name: getattr(self.space, name).numpy() for name in TENSORS if name != "Y"} | {
            "Y": self.space.Y.numpy().astype(np.float32),
            "evecs": np.stack([basis.evecs for basis in bases]).astype(np.float16),  # enough for maps
            "mass": np.stack([basis.mass for basis in bases]),
            "vertices": self.vertices.astype(np.float32),
            "faces": self.faces.astype(np.int32),
            "names": np.array(list(self.names)),
            "operators": np.array(list(self.operators)),
            "live": self.features.live,
            "centre": self.centre.astype(np.float32),
            "weights": self.weights.astype(np.float32),
            "mean": self.mean,
            "widths": self.widths,
            "told": np.array([FORMAT, self.level, self.farthest, self.features.weight]),
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.draft")
        try:
            with draft.open("wb") as stream:
                np.savez(stream, **arrays)
            os.replace(draft, path)
        finally:
            draft.unlink(missing_ok=True)
        return path

    @classmethod
    def load(cls, path: str | Path) -> "BodyReader":
        """Read what `save` wrote.

        Raises:
            InputError: no such file, or another one.
        """
        path = Path(path)
        if not path.is_file():
            raise InputError(f"{path}: no such file; expected a reader of body measures, which task=reader makes")
        with reading(path):
            data = path.read_bytes()
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                arrays = dict(file)
            form, level, farthest, weight = arrays["told"].tolist()
            if form != FORMAT:
                raise InputError(f"{path}: expected a reader of format {FORMAT}, got {form:g}; make it again")
            vertices, faces = arrays["vertices"].astype(float), arrays["faces"].astype(np.int64)
            connectivity = Mesh(vertices[0], faces).connectivity
            bases = [
                Eigenbasis(evals, evecs.astype(float), mass, connectivity)
                for evals, evecs, mass in zip(arrays["evals"], arrays["evecs"], arrays["mass"], strict=True)
            ]
            tensors: dict[str, Any] = {name: torch.from_numpy(arrays[name]).double() for name in TENSORS}
            space = LatentSpace(**tensors, bases=bases, names=tuple(map(str, range(len(bases)))))
            parts = {name: arrays[name].astype(float) for name in ("centre", "weights", "mean", "widths")}
            names, operators = (tuple(arrays[name].tolist()) for name in ("names", "operators"))
            features = Features(arrays["live"], weight)
            return cls(
                space, vertices, faces, operators, features, **parts, names=names, level=level, farthest=farthest
            )
        except (ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{path}: expected a reader of body measures, which task=reader makes") from error
