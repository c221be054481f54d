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
from functools import partial
from pathlib import Path
from typing import Any

from lssd_learn import collections, nets
from lssd_learn.cache import DEFAULT, Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.learning import Classification, Reconstruction, Regression, VertexReconstruction, checkpoint
from lssd_learn.models.model import Trained
from lssd_learn.pipeline import Pipeline, describe

# What the checkpoint of a task holds beside net and inputs.
HOLDS = {"regression": "parameters", "classification": "classes", "reconstruction": "faces"}


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
    path: str | Path,
    net: Callable | None,
    cache: Cache | None = None,
    tasks: Sequence[str] = ("regression",),
    workers: int | None = None,
) -> Trained:
    """What one of some tasks has trained, from its best.ckpt.

    Args:
        path: the file.
        net: takes the place of the net named in the file if that is none of `lssd_learn.nets`.
        cache: where the eigenbases of the latent space are looked up.
        tasks: what it may have been trained for, some of `HOLDS`.
        workers: processes of the model, see `in_parallel`.

    Raises:
        InputError: no checkpoint, one of another task, one that lacks what it takes to read new shapes.
    """
    content = checkpoint.read(path)
    wanted = f"{path}: expected the best.ckpt of {' or '.join(f'task={task}' for task in tasks)}, but it"
    if "latent" not in content and "points" not in content:
        raise InputError(f"{wanted} holds no latent space")
    task = next((task for task in tasks if HOLDS[task] in content), None)
    if task is None or "net" not in content:
        lacks = "net" if "net" not in content else " or ".join(HOLDS[task] for task in tasks)
        raise InputError(f"{wanted} does not name its {lacks}")
    chosen = _rebuild(content["net"]) or net
    if chosen is None:
        raise InputError(f"{path}: its net {content['net'][0]} is none of lssd_learn.nets; give net=, the class of it")
    faces = content.get("faces")
    modules = {
        "regression": Regression,
        "classification": Classification,
        "reconstruction": Reconstruction if faces is None else VertexReconstruction,
    }
    return Trained(
        learner=checkpoint.load(path, chosen, modules[task]),
        parameters=list(content.get("parameters", ())),
        latent=LatentSpace.load(path, cache) if "latent" in content else None,
        operators=content.get("operators", []),
        laplacian=content.get("laplacian", "auto"),
        points=content.get("points"),
        faces=faces,
        known=partial(_make, content["collection"]) if "collection" in content else None,
        group=content.get("group", ""),
        classes=content.get("classes", ()),
        cache=cache,
        workers=workers,
    )


def load(
    path: str | Path, cache: Cache | None = DEFAULT, net: Callable | None = None, workers: int | None = None
) -> Trained:
    """A trained model from the best.ckpt of a regression, classification or reconstruction.

    Args:
        path: the file.
        cache: where the eigenbases of its training shapes are looked up, and those of new shapes kept.
        net: the class of its net, if that is none of `lssd_learn.nets`.
        workers: processes, see `in_parallel`.

    Raises:
        InputError: no checkpoint, or one that lacks what it takes to read new shapes.
    """
    return read_trained(Path(path).expanduser(), net, cache, list(HOLDS), workers)


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
