"""What a checkpoint says of the inputs it was trained on, so that the same can be made of new shapes: put in, read out.

Beside the weights best.ckpt holds

    net         the class of the net and its options
    latent      of a net on operators: the latent space,
    operators   which differences are its channels,
    laplacian   what the eigenbases were computed with
    collection  and which shapes these are, as the configuration describes them
    points      of a net on clouds: how many
    parameters  of a regression: the name of each output
    group       of a classification: its name,
    classes     and the label of each output
    faces       of a reconstruction: those of its meshes, None of clouds
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from torch import Tensor

from lssd_learn import collections, nets
from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.learning import Classification, Learner, Reconstruction, Regression, VertexReconstruction, load
from lssd_learn.learning.checkpoint import read
from lssd_learn.pipeline import Pipeline, describe

# What the checkpoint of a task holds beside net and inputs.
HOLDS = {"regression": "parameters", "classification": "classes", "reconstruction": "faces"}


@dataclass(frozen=True)
class Trained:
    """A trained regression, classification or reconstruction.

    Attributes:
        learner: predicts from raw inputs.
        parameters: the names of what a regression predicts.
        latent: the space of its operators; None if it reads clouds.
        operators: which differences are the channels.
        laplacian: of the eigenbases.
        points: of each cloud; None if it reads operators.
        faces: (F, 3) of the meshes a reconstruction gives; None if it gives clouds.
        collection: makes the shapes of the latent space; None where the file does not say which they are.
        group: what a classification tells, and
        classes: the labels of its outputs.
    """

    learner: Learner
    parameters: list[str]
    latent: LatentSpace | None
    operators: list[str]
    laplacian: str
    points: int | None
    faces: Tensor | None = None
    collection: Callable[[], Collection] | None = None
    group: str = ""
    classes: Sequence[str] = ()


def inputs_state(
    net: Callable, pipeline: Pipeline, operators: Sequence[str], points: int, described: dict
) -> dict[str, Any]:
    """What the checkpoint of a run holds of its net and inputs: tensors and plain containers.

    Args:
        net: a partial of its class.
        pipeline: that its inputs come from.
        operators: which differences are its channels, if it reads operators.
        points: of each cloud, if it reads those.
        described: the collection, as the configuration describes it.
    """
    state: dict[str, Any] = {"net": describe(net)}
    if nets.reads(net) == "clouds":
        return state | {"points": points}
    # An operator of another latent space is another language: the net travels with the space it was trained in.
    return state | {
        "latent": pipeline.latent.state(),
        "operators": list(operators),
        "laplacian": pipeline.laplacian,
        "collection": described,
    }


def read_trained(
    path: Path, net: Callable, cache: Cache | None = None, tasks: Sequence[str] = ("regression",)
) -> Trained:
    """What one of some tasks has trained, from its best.ckpt.

    Args:
        path: the file.
        net: takes the place of the net named in the file if that is none of `lssd_learn.nets`.
        cache: where the eigenbases of the latent space are looked up.
        tasks: what it may have been trained for, some of `HOLDS`.

    Raises:
        InputError: no checkpoint, one of another task, one that lacks what it takes to read new shapes.
    """
    checkpoint = read(path)
    wanted = f"{path}: expected the best.ckpt of {' or '.join(f'task={task}' for task in tasks)}, but it"
    if "latent" not in checkpoint and "points" not in checkpoint:
        raise InputError(f"{wanted} holds no latent space")
    task = next((task for task in tasks if HOLDS[task] in checkpoint), None)
    if task is None or "net" not in checkpoint:
        lacks = "net" if "net" not in checkpoint else " or ".join(HOLDS[task] for task in tasks)
        raise InputError(f"{wanted} does not name its {lacks}")
    faces = checkpoint.get("faces")
    modules = {
        "regression": Regression,
        "classification": Classification,
        "reconstruction": Reconstruction if faces is None else VertexReconstruction,
    }
    return Trained(
        learner=load(path, _rebuild(checkpoint["net"]) or net, modules[task]),
        parameters=list(checkpoint.get("parameters", ())),
        latent=LatentSpace.load(path, cache) if "latent" in checkpoint else None,
        operators=checkpoint.get("operators", []),
        laplacian=checkpoint.get("laplacian", "auto"),
        points=checkpoint.get("points"),
        faces=faces,
        collection=partial(_make, checkpoint["collection"]) if "collection" in checkpoint else None,
        group=checkpoint.get("group", ""),
        classes=checkpoint.get("classes", ()),
    )


def _make(described: dict) -> Collection:
    """The collection of a configuration, if it is one of ours: a file shall not name code to run."""
    given = {name: _make(value) if _is_node(value) else value for name, value in described.items()}
    name = str(given.pop("_target_", "")).rpartition(".")[2]
    kind = getattr(collections, name) if name in collections.__all__ else None
    if not (isinstance(kind, type) and issubclass(kind, Collection)):
        raise InputError(f"ckpt_path: expected a checkpoint that names a collection of this program, got {name!r}")
    return kind(**given)


def _is_node(value: Any) -> bool:
    return isinstance(value, dict) and "_target_" in value


def _rebuild(described: list) -> Callable | None:
    """A partial of the net that `describe` described, if it is one of ours: a file shall not name code to run."""
    name, options = described[0].rpartition(".")[2], described[-1]
    return partial(getattr(nets, name), **options) if name in nets.__all__ and name[0].isupper() else None
