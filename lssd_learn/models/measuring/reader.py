"""The reader of body measures: a body that varies as people do is laid on a scan, put at rest, and measured."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from lssd_learn.errors import InputError, reading
from lssd_learn.models.measuring.conformal import Widths
from lssd_learn.models.measuring.figure import Figure
from lssd_learn.models.measuring.fit import Fit
from lssd_learn.models.measuring.laying import Layer, upright
from lssd_learn.models.measuring.units import METRES, find_unit, in_metres
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.written import write_arrays

FORMAT = 3
SHIPPED = Path(__file__).with_name("people.npz")  # made by experiment=measures
FEWEST = 1000  # points of a scan
PARTS = ("loose", "weights", "turns")  # of the layer, in single precision
INTERVALS = ("low", "high", "scales", "ends", "widths")


@dataclass(frozen=True, eq=False)
class Reading:
    """What is read of one scan.

    Attributes:
        unit: of the scan.
        values, low, high: (p,) each measure, and the interval that holds with the reader's `level`.
        off: how far the scan is from the body that was laid on it, root mean square, in mm, 30 at most.
        missing, extra: the part of the body that the scan has nothing of, and of the scan that the body has nothing of.
        unlike: how far the person is from the mean of those that the reader learnt from, in standard deviations.
        signs: of faults of the scan, in plain words; empty where there are none.
        points: (V, 3) of the body on the scan, in the unit of that, and upright (3, 3), which turns rows of them so
            that the hips stand as they do at rest.
        tapes: name of each girth → (h, 3) where its tape lies, in the unit of the scan.
    """

    unit: str
    values: Float[np.ndarray, " p"]
    low: Float[np.ndarray, " p"]
    high: Float[np.ndarray, " p"]
    off: float
    missing: float
    extra: float
    unlike: float
    signs: tuple[str, ...]
    points: Float[np.ndarray, "V 3"]
    upright: Float[np.ndarray, "3 3"]
    tapes: Mapping[str, Float[np.ndarray, "h 3"]]


@dataclass(frozen=True, eq=False)
class BodyReader:
    """Reads the measures of scans of people, in any pose and however they lie.

    Attributes:
        layer: lays a body on scans.
        names: p measures, see `MEASURES`.
        mean: (p,) of the logarithms of the measures of the people it learnt from.
        widths: of the intervals, in logarithms, by `seen`, and level, the probability that they hold with.
        clean, farthest: (4,) the most of `off` in mm, `missing`, `extra` and `unlike` of nearly all scans without
            faults, and of a scan that is to be read.
    """

    layer: Layer
    names: Sequence[str]
    mean: Float[np.ndarray, " p"]
    widths: Widths
    level: float
    clean: Float[np.ndarray, "4"]
    farthest: Float[np.ndarray, "4"]

    @property
    def figure(self) -> Figure:
        return self.layer.figure

    def read(self, shape: Shape, unit: str = "auto", name: str = "scan") -> Reading:
        """The measures of one scan.

        Args:
            shape: a mesh or a cloud, lying anyhow.
            unit: of its coordinates: m, cm, mm, or auto, which finds out.
            name: of it, for errors.

        Raises:
            InputError: too few points, of no grown-up's size, or no body lies on it.
        """
        if len(shape.points) < FEWEST:
            raise InputError(f"{name}: expected a scan of {FEWEST} points or more, got {len(shape.points)}")
        try:
            unit = find_unit(shape, unit)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        fit = self.layer.lay(in_metres(shape, unit))
        told = faults(fit)
        if (told > self.farthest).any():
            most = self.farthest
            raise InputError(
                f"{name}: expected a whole body of a grown-up, but the nearest is {told[0]:.1f} mm off (up to "
                f"{most[0]:.1f} is read), {100 * told[1]:.0f} % of it are missing ({100 * most[1]:.0f}), "
                f"{100 * told[2]:.0f} % of the scan are something else ({100 * most[2]:.0f}), and it is {told[3]:.1f} "
                f"standard deviations from the mean ({most[3]:.1f})"
            )
        found = self.figure.measured(fit.pose.weights)
        width, per = self.widths(seen(fit, shape)), METRES[unit]
        tapes = {girth: points / per for girth, points in self.figure.tapes(fit.pose.weights, fit.lying).items()}
        off, missing, extra, unlike = told.tolist()
        return Reading(
            unit, found, found * np.exp(-width), found * np.exp(width), off, missing, extra, unlike,
            signs(told, self.clean), fit.lying.points / per, upright(fit.pose), tapes,
        )  # fmt: skip

    def save(self, path: str | Path) -> Path:
        """Write it as one .npz file, the same bytes for the same reader."""
        widths = {name: getattr(self.widths, name) for name in INTERVALS}
        arrays = self.figure.packed() | {name: getattr(self.layer, name).astype(np.float32) for name in PARTS}
        arrays |= widths | {
            "names": np.array(list(self.names)),
            "mean": self.mean,
            "clean": self.clean,
            "farthest": self.farthest,
            "told": np.array([FORMAT, self.level]),
        }
        return write_arrays(arrays, Path(path))

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
            form, level = arrays["told"][:2].tolist()
            if form != FORMAT:
                raise InputError(f"{path}: expected a reader of format {FORMAT}, got {form:g}; make it again")
            layer = Layer(Figure.unpacked(arrays), **{name: arrays[name].astype(float) for name in PARTS})
            widths = Widths(**{name: arrays[name] for name in INTERVALS})
            names = tuple(arrays["names"].tolist())
            return cls(layer, names, arrays["mean"], widths, level, arrays["clean"], arrays["farthest"])
        except (ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{path}: expected a reader of body measures, which task=reader makes") from error


def faults(fit: Fit) -> Float[np.ndarray, "4"]:
    """(4,) `off` in mm, `missing`, `extra` and `unlike` of `Reading`."""
    return np.array([1000 * fit.off, fit.missing, fit.extra, np.sqrt(np.mean(fit.pose.weights**2))])


def seen(fit: Fit, shape: Shape) -> Float[np.ndarray, "4"]:
    """(4,) what is known of a scan that tells how large errors are."""
    return np.array([np.log(fit.off + 1e-5), fit.missing, fit.extra, float(not isinstance(shape, Mesh))])


def signs(told: Float[np.ndarray, "4"], clean: Float[np.ndarray, "4"]) -> tuple[str, ...]:
    """What of a scan is more than that of any scan without faults, see `faults`."""
    words = (
        f"rough or clothed: {told[0]:.1f} mm off a body",
        f"{100 * told[1]:.0f} % of the body are missing",
        f"{100 * told[2]:.0f} % of the scan are no part of the body",
        f"unlike the people that the reader knows: {told[3]:.1f} standard deviations from their mean",
    )
    return tuple(word for word, value, most in zip(words, told, clean, strict=True) if value > most)
