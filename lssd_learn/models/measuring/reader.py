"""The reader of body measures: a few bodies to map scans to, and a ridge on distances between points of them there."""

import io
import os
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float

from lssd_learn.cache import Cache
from lssd_learn.collections import AtHand
from lssd_learn.errors import InputError, reading
from lssd_learn.models.measuring.features import Chords
from lssd_learn.models.measuring.landing import References
from lssd_learn.models.measuring.tapes import Loop, packed, unpacked
from lssd_learn.models.measuring.units import METRES, find_unit, in_metres
from lssd_learn.shapes import Mesh, Shape

FORMAT = 2
SHIPPED = Path(__file__).with_name("people.npz")  # made by experiment=measures
SINGLE = ("centre", "span", "weights")  # what the file has in single precision


@dataclass(frozen=True, eq=False)
class Reading:
    """What is read of one scan.

    Attributes:
        unit: of the scan.
        values, low, high: (p,) each measure, and the interval that holds with the reader's `level`.
        unlike: how far its distances are from those of any body, root mean square of relative differences.
        quality: of the map that it was read through, in [0, 1].
        body: the reference that it was mapped to, and
        points: (V, 3) where its vertices lie on the scan, in the unit of that.
    """

    unit: str
    values: Float[np.ndarray, " p"]
    low: Float[np.ndarray, " p"]
    high: Float[np.ndarray, " p"]
    unlike: float
    quality: float
    body: int
    points: Float[np.ndarray, "V 3"]


@dataclass(frozen=True, eq=False)
class BodyReader:
    """Reads the measures of scans of people, in any pose and however they lie.

    Attributes:
        references: bodies that scans are mapped to.
        chords: the d distances that are known of a scan.
        centre: (d,) of their logarithms on scans.
        span: (r, d) orthonormal: how bodies differ in them.
        weights: (d, p), mean (p,) of the logarithms of the measures.
        widths: (p,) of the intervals, in logarithms, and `level`, the probability that they hold with.
        names: p measures, see `MEASURES`.
        farthest: the largest `unlike` of a body that is to be read.
        loops: name of each girth → where its tape lies on the references.
    """

    references: References
    chords: Chords
    centre: Float[np.ndarray, " d"]
    span: Float[np.ndarray, "r d"]
    weights: Float[np.ndarray, "d p"]
    mean: Float[np.ndarray, " p"]
    widths: Float[np.ndarray, " p"]
    names: Sequence[str]
    level: float = 0.9
    farthest: float = np.inf
    loops: Mapping[str, Loop] = field(default_factory=dict)

    def read(self, shape: Shape, unit: str = "auto", name: str = "scan", cache: Cache | None = None) -> Reading:
        """The measures of one scan.

        Args:
            shape: a mesh, lying anyhow.
            unit: of its coordinates: m, cm, mm, or auto, which finds out.
            name: of it, for errors.
            cache: where its eigenbasis is kept.

        Raises:
            InputError: a cloud; of no grown-up's size, unlike the reader's bodies, or no map to one can be trusted.
        """
        if not isinstance(shape, Mesh):
            raise InputError(
                f"{name}: expected a mesh, got a cloud of {len(shape.points)} points: reconstruct its surface"
            )
        try:
            unit = find_unit(shape, unit)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        scans = AtHand([in_metres(shape, unit)])
        scans.names = [name]
        landed = self.references.land(scans, cache)
        features = self.chords(landed.points)
        beyond, quality = float(self.unlike(features)[0]), float(landed.quality[0])
        if beyond > self.farthest:
            raise InputError(
                f"{name}: expected a whole body of a grown-up, but distances along it are {100 * beyond:.0f} % off "
                f"those of any (up to {100 * self.farthest:.0f} is read)"
            )
        if quality < landed.level:
            raise InputError(
                f"{name}: expected a whole body of a grown-up, but no map to one can be trusted (quality "
                f"{quality:.2f} of {landed.level:g})"
            )
        found = self.predict(features)[0]
        low, high = found * np.exp(-self.widths), found * np.exp(self.widths)
        points = landed.points[0] / METRES[unit]
        return Reading(unit, found, low, high, beyond, quality, int(landed.bodies[0]), points)

    def unlike(self, features: Float[np.ndarray, "n d"]) -> Float[np.ndarray, " n"]:
        """(n,) how far scans with these `features` are from any body, see `Reading`."""
        off = features - self.centre
        return np.sqrt(((off - off @ self.span.T @ self.span) ** 2).mean(1))

    def predict(self, features: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "n p"]:
        """(n, p) the measures of scans with these `features` (n, d)."""
        return np.exp(self.mean + (features - self.centre) @ self.weights)

    def save(self, path: str | Path) -> Path:
        """Write it as one .npz file, the same bytes for the same reader."""
        path, arrays = Path(path), {name: getattr(self, name).astype(np.float32) for name in SINGLE}
        arrays |= {
            "vertices": self.references.vertices.astype(np.float32),
            "faces": self.references.faces.astype(np.int32),
            "pairs": self.chords.pairs.astype(np.int32),
            "names": np.array(list(self.names)),
            "mean": self.mean,
            "widths": self.widths,
            "told": np.array([FORMAT, self.level, self.farthest]),
            **packed(self.loops),
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
    def load(cls, path: str | Path = SHIPPED) -> "BodyReader":
        """Read what `save` wrote; by default the reader that comes with the package.

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
            form, level, farthest = arrays["told"][:3].tolist()
            if form != FORMAT:
                raise InputError(f"{path}: expected a reader of format {FORMAT}, got {form:g}; make it again")
            known = References(arrays["vertices"].astype(float), arrays["faces"].astype(np.int64))
            parts = {name: arrays[name].astype(float) for name in (*SINGLE, "mean", "widths")}
            return cls(
                known,
                Chords(arrays["pairs"].astype(np.int64)),
                **parts,
                names=tuple(arrays["names"].tolist()),
                level=level,
                farthest=farthest,
                loops=unpacked(arrays),
            )
        except (ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{path}: expected a reader of body measures, which task=reader makes") from error
