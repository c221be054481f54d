"""`task=reconstruction`: shapes out of their operators, beside what can be had without a net."""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning.pytorch.utilities import rank_zero_only
from torch import Tensor

from lssd_learn import nets
from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.learning import Learner, Reconstruction, Split, VertexReconstruction, load
from lssd_learn.learning.scores.reconstructed import Answer, NearestPose, means, score_answers, write_scores
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.tasks.training import TURNING, plan, train
from lssd_learn.view.exports import export
from lssd_learn.view.sheets import shape_sheet, write_sheets

log = logging.getLogger(__name__)

MODULES = {"clouds": Reconstruction, "vertices": VertexReconstruction}
WORDS = {
    "mean": "mean of the training split",
    "middle": "training shape in the middle",
    "nearest": "training shape of the nearest operator",
}


def run(
    pieces: Pieces,
    out: Path,
    epochs: int,
    points: int = 4096,
    milestones: Sequence[int] = (),
    shown: int = 8,
    threads: int = 1,
) -> dict[str, float]:
    """Train a net to draw the shapes of the collection; write scores.csv, reconstruction.png, reconstructions/.

    A net that gives clouds learns clouds of `points` points; one that gives vertices learns those, of shapes that all
    have the same faces, and its meshes are scored by as many points. best.ckpt holds `faces`, None of a cloud.

    Args:
        epochs: passes over the training split.
        points: of each cloud.
        milestones: epochs up to which the best is scored too.
        shown: test shapes in pictures and files, one a pose first.
        threads: of the training.

    Returns:
        test/ and reference/<name>/ with cd, cd_over_level, f_1cm, f_2cm (see `CloudScores`), vertex_error_mm of meshes
        with the faces of the truth, pose_agreement where the collection knows poses: whether the nearest training shape
        is in the true one; and the metrics of `lssd_learn.learning.fit`. The references are, of the training split,
            mean      of all vertices, where all shapes have the same faces;
            middle    elsewhere: the shape whose area operator is nearest to the mean operator;
            nearest   the shape with the nearest area operator.

    Raises:
        InputError: a net that gives neither, shapes that have no surface or, for vertices, other faces.
    """
    gives, collection = nets.writes(pieces.net), pieces.pipeline.collection
    if gives not in MODULES:
        known = "reconstructor, autoencoder or vertices"
        raise InputError(f"net={pieces.choices['net']}: expected one that draws shapes for this task: {known}")
    check_whole("task.points", points, 1)
    check_whole("task.shown", shown, 1)
    if nets.reads(pieces.net) == "clouds" and pieces.data.augment in TURNING:
        raise InputError("data.augment=turn: a cloud that is turned would be asked for as it was; expected resample")
    parts, epochs = plan(pieces, epochs, MODULES[gives])
    for i in parts.test:
        if not isinstance(collection[i], Mesh):
            raise InputError(f"{collection.names[i]}: expected a mesh to compare with, it has no faces")
    if pieces.pipeline.origin.any():
        raise InputError(f"task=reconstruction: expected shapes near the origin, got {collection.names[0]} far from it")
    clouds, common = pieces.pipeline.clouds(points), _common(collection)
    vertices, faces = (None, None) if common is None or gives != "vertices" else common
    if gives == "vertices" and common is None:
        raise InputError("net=vertices: expected shapes that all have the same faces, so that vertices correspond")

    metrics = train(
        pieces,
        out,
        clouds if vertices is None else vertices,
        parts,
        epochs,
        milestones=milestones,
        module=MODULES[gives],
        carries={"faces": None if faces is None else torch.tensor(faces)},
        threads=threads,
    )
    if rank_zero_only.rank != 0:  # of the processes of a distributed run, one
        return metrics
    learner = load(out / "best.ckpt", pieces.net, MODULES[gives])
    drawn = draw(learner, _inputs(pieces)[parts.test], faces)
    answers: dict[str, Answer] = {"net": dict(zip(parts.test.tolist(), drawn, strict=True)).__getitem__}
    answers |= _references(pieces, parts, common)
    rows = score_answers(answers, collection, parts.test, clouds, _poses(collection, clouds, parts))
    write_scores(rows, [collection.names[int(i)] for i in parts.test], out / "scores.csv")
    _show(pieces, out, parts, answers, shown)
    found = {name: means(scores) for name, scores in rows.items()}
    title = f"{pieces.choices['net']}, epoch {metrics['best_epoch']}"
    _tell(found, {"net": title, **WORDS}, f"{len(parts.test)} test shapes, {points:,} points each:")
    log.info("scores.csv, reconstruction.png; the shapes in it as PLY and GLB: reconstructions/")
    return {
        **{f"test/{key}": value for key, value in found.pop("net").items()},
        **{key: value for key, value in metrics.items() if key != "test/cd"},
        **{f"reference/{name}/{key}": value for name, scores in found.items() for key, value in scores.items()},
    }


@torch.no_grad()
def draw(learner: Learner, inputs: Tensor, faces: np.ndarray | None, batch: int = 50) -> list[Shape]:
    """The shapes a trained net makes of raw inputs: meshes of these faces, or clouds without."""
    drawn = torch.cat([learner(some.to(learner.mean)) for some in inputs.split(batch)]).double().numpy()
    return [PointCloud(points) if faces is None else Mesh(points, faces) for points in drawn]


def _inputs(pieces: Pieces) -> Tensor:
    """What the net reads of every shape."""
    if nets.reads(pieces.net) == "clouds":
        return torch.tensor(pieces.pipeline.clouds(pieces.data.points))
    return pieces.pipeline.operators(pieces.operators)


def _common(collection: Collection) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertices (n, V, 3) float32 and faces (F, 3) of shapes that all have the same faces; None of others."""
    vertices = faces = connectivity = None
    for i, shape in enumerate(track(collection, "reading vertices", len(collection))):
        if vertices is None:
            vertices = np.empty((len(collection), *shape.vertices.shape), dtype=np.float32)
            faces, connectivity = getattr(shape, "faces", None), shape.connectivity
        if connectivity is None or shape.connectivity != connectivity:
            return None
        vertices[i] = shape.vertices
    return None if vertices is None or faces is None else (vertices, faces)


def _references(pieces: Pieces, parts: Split, common: tuple[np.ndarray, np.ndarray] | None) -> dict[str, Answer]:
    collection = pieces.pipeline.collection
    area = pieces.pipeline.operators()[:, 0].flatten(1)
    known = area[parts.train]
    if common is None:
        middle = collection[parts.train[(known - known.mean(0)).norm(dim=1).argmin()]]
    else:
        middle = Mesh(common[0][parts.train].mean(0, dtype=np.float64), common[1])
    nearest = {i: parts.train[(known - area[i]).norm(dim=1).argmin()] for i in parts.test.tolist()}
    return {"middle" if common is None else "mean": lambda i: middle, "nearest": lambda i: collection[nearest[i]]}


def _poses(collection: Collection, clouds: np.ndarray, parts: Split) -> tuple[NearestPose, np.ndarray] | None:
    if "pose" not in collection.groups:
        return None
    poses = np.asarray(collection.groups["pose"]).astype(str)
    return NearestPose(clouds[parts.train], poses[parts.train]), poses


def _show(pieces: Pieces, out: Path, parts: Split, answers: Mapping[str, Answer], shown: int) -> None:
    """The first test shape of every pose, then the others: a sheet, a TensorBoard page, files."""
    collection = pieces.pipeline.collection
    labels = np.asarray(next(iter(collection.groups.values()), np.zeros(len(collection)))).astype(str)
    first = np.sort(np.unique(labels[parts.test], return_index=True)[1])
    order = np.concatenate([first, np.setdiff1d(np.arange(len(parts.test)), first)])
    chosen = parts.test[order[:shown]].tolist()
    rows: dict[str, list[Shape]] = {"truth": [collection[i] for i in chosen]}
    rows |= {name: [answer(i) for i in chosen] for name, answer in answers.items()}
    net = rows.pop("net")
    rows = {"truth": rows.pop("truth"), pieces.choices["net"]: net, **rows}
    titles = [f"{collection.names[i]}\n{labels[i] if collection.groups else ''}" for i in chosen]
    sheet = shape_sheet({name: dict(zip(titles, row, strict=True)) for name, row in rows.items()}, collection.up)
    sheet.savefig(out / "reconstruction.png")
    scenes = {"reconstruction/truth": rows["truth"], "reconstruction/net": net}
    write_sheets(out / "tensorboard", {"reconstruction/sheet": sheet}, scenes, collection.up)
    for i, truth, shape in zip(chosen, rows["truth"], net, strict=True):
        export(shape, out / "reconstructions", collection.names[int(i)], collection.up)
        export(truth, out / "reconstructions", f"{collection.names[i]}_truth", collection.up)


def _tell(found: Mapping[str, Mapping[str, float]], words: Mapping[str, str], title: str) -> None:
    """The table in the log."""
    columns: dict[str, tuple[str, Any]] = {
        "cd": ("CD", "{:.6f}"),
        "cd_over_level": ("of perfect", "{:.2f}"),
        "f_1cm": ("F 1 cm", "{:.3f}"),
        "f_2cm": ("F 2 cm", "{:.3f}"),
        "vertex_error_mm": ("vertex mm", "{:.2f}"),
        "pose_agreement": ("right pose", "{:.0%}"),
    }
    columns = {key: column for key, column in columns.items() if any(key in scores for scores in found.values())}
    log.info("%s", title)
    log.info("  %-40s %s", "", " ".join(f"{heading:>10}" for heading, _ in columns.values()))
    for name, scores in found.items():
        cells = [form.format(scores[key]) if key in scores else "" for key, (_, form) in columns.items()]
        log.info("  %-40s %s", words[name], " ".join(f"{cell:>10}" for cell in cells))
