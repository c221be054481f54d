"""`task=reader_benchmark`: a reader of body measures beside what else there is, on people whose measures are known."""

import logging
from pathlib import Path
from typing import cast

import numpy as np
from jaxtyping import Float

from lssd_learn.collections import Collection, Faulty, People, Remeshed
from lssd_learn.collections.anthropometry.measures import NAMES, TOPOLOGY
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.collections.generated.measured import measured
from lssd_learn.errors import InputError, check_whole
from lssd_learn.kdtree import cKDTree
from lssd_learn.measures.rivals.pointnet import read_by_net
from lssd_learn.measures.rivals.sections import read_by_sections
from lssd_learn.models.measuring import BodyReader, Reading
from lssd_learn.models.measuring.table import read_all
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.sampling import sample
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "rivals.csv"
ROUNDS = 3  # of closest points


def run(
    pieces: Pieces, out: Path, reader: str | None = None, people: int = 2000, epochs: int = 60, inverted: int = 20
) -> dict[str, float]:
    """Write rivals.csv: of each measure the mean absolute error of the reader and of each rival, in its unit.

    Rivals are the mean of the people that the reader learnt from; sections of the scan at the heights where tapes lie
    on the mean person, see `read_by_sections`; a PointNet; and the body model's own inverter, with closest points for
    correspondence, and with the true one. Scans are in metres.

    Args:
        reader: a file that task=reader has written; None is the one that comes with the package.
        people: whose clouds the net is trained on, for so many epochs.
        inverted: scans, the first, that the inverter is asked about.

    Returns:
        "l1/…", the mean over the girths and lengths in millimetres, of the reader and each rival.

    Raises:
        InputError: people whose measures are not known, no scan that can be read.
    """
    scans = pieces.pipeline.collection
    if scans.parameters is None or list(scans.parameter_names) != list(NAMES):
        raise InputError("task=reader_benchmark: expected people whose measures are known: collection=remeshed_people")
    for name, value in (("people", people), ("epochs", epochs), ("inverted", inverted)):
        check_whole(f"task.{name}", value, 1)
    known = BodyReader.load() if reader is None else BodyReader.load(Path(reader).expanduser())
    found, refused = read_all(known, scans)
    for line in refused:
        log.warning("%s", line)
    if not found:
        raise InputError(f"none of {len(refused)} scans can be read; the first: {refused[0]}")
    numbers = [i for i, name in enumerate(scans.names) if name in found]
    readings, shapes = list(found.values()), [scans[i] for i in numbers]
    truth, few = scans.parameters[numbers], slice(inverted)
    read = {
        "reader": np.stack([reading.values for reading in readings]),
        "mean": np.tile(np.exp(known.mean), (len(shapes), 1)),
        "net": read_by_net(shapes, people, epochs),
    }
    if all(isinstance(shape, Mesh) for shape in shapes):
        pairs = zip(shapes, readings, strict=True)
        read["sections"] = np.stack(
            [read_by_sections(known, cast(Mesh, shape), reading.upright[:, 2]) for shape, reading in pairs]
        )
    pairs = list(zip(shapes, readings, strict=True))[few]
    read["inverter"] = np.stack([_inverted(known, *pair) for pair in track(pairs, "inverting")])
    if (origin := _origin(scans)) is not None:
        lying = [origin[i].vertices for i in numbers[few]]
        read["inverter_true"] = measured([body_model(TOPOLOGY).inverted(points)[0] for points in lying])
    errors = {name: np.abs(values - truth[: len(values)]).mean(axis=0) for name, values in read.items()}
    write_columns({"measure": list(NAMES)} | {name: some.tolist() for name, some in errors.items()}, out / TABLE)
    millimetres = [name.endswith("_mm") for name in NAMES]
    for name, some in errors.items():
        log.info("%-14s %.1f mm in the mean over girths and lengths", name, some[millimetres].mean())
    return {f"l1/{name}": float(some[millimetres].mean()) for name, some in errors.items()}


def _inverted(reader: BodyReader, shape: Shape, reading: Reading) -> Float[np.ndarray, " p"]:
    """(p,) by the inverter, whose vertices are taken to lie at the closest points of a scan in metres, from where the
    person that lies most like it does."""
    surface = sample(shape, 20000, np.random.default_rng(0))
    layer, tree = reader.layer, cKDTree(surface)
    pose = layer.starts.nearest(surface[: len(layer.starts.body.mean)], 1)[0]
    lying = reader.figure.body.lying(pose).points
    for _ in range(ROUNDS):
        sliders, lying = body_model(TOPOLOGY).inverted(surface[tree.query(lying)[1]])
    return measured([sliders])[0]


def _origin(scans: Collection) -> People | None:
    """The people that scans were made of."""
    while isinstance(scans, Remeshed | Faulty):
        scans = scans.base
    return scans if isinstance(scans, People) and scans.topology == TOPOLOGY else None
