"""What a checkpoint says of the inputs it was trained on, so that the same can be made of new shapes: put in, read out.

Beside the weights best.ckpt holds

    net         the class of the net and its options
    latent      of a net on operators: the latent space,
    operators   which differences are its channels,
    laplacian   what the eigenbases were computed with
    collection  and which shapes these are, as the configuration describes them
    points      of a net on clouds: how many,
    sizes       and the radii of those it was trained on,
    origin      and what was taken off their points,
    align       and how those were laid alike
    parameters  of a regression: the name of each output
    group       of a classification: its name,
    classes     and the label of each output
    faces       of a reconstruction: those of its meshes, None of clouds
    by, seen    of a split by blocks: the group, and its labels in training and validation
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import torch
from torch import nn

from lssd_learn import collections, nets
from lssd_learn.cache import DEFAULT, Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.learning import Classification, Reconstruction, Regression, VertexReconstruction, checkpoint
from lssd_learn.models.model import Trained
from lssd_learn.models.unlike import radii
from lssd_learn.partials import unbound
from lssd_learn.pipeline import Pipeline, describe
from lssd_learn.plugins import find_class

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
        sizes = torch.from_numpy(radii(torch.tensor(pipeline.clouds(points))))
        origin, align = torch.from_numpy(pipeline.origin), str(described.get("align", "none"))
        return state | {"points": points, "sizes": sizes, "origin": origin, "align": align}
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
        net: of the configuration in use; the file may name it, or one of `lssd_learn.nets` or of a plug-in.
        cache: where the eigenbases of the latent space are looked up.
        tasks: what it may have been trained for, some of `HOLDS`.
        workers: processes of the model, see `in_parallel`.

    Raises:
        InputError: no checkpoint, one of another task, one that lacks what it takes to read new shapes, one whose net
            is somebody's who may not be named.
    """
    content = checkpoint.read(path)
    wanted = f"{path}: expected the best.ckpt of {' or '.join(f'task={task}' for task in tasks)}, but it"
    if "latent" not in content and "points" not in content:
        raise InputError(f"{wanted} holds no latent space")
    task = next((task for task in tasks if HOLDS[task] in content), None)
    if task is None or "net" not in content:
        lacks = "net" if "net" not in content else " or ".join(HOLDS[task] for task in tasks)
        raise InputError(f"{wanted} does not name its {lacks}")
    chosen = _rebuild(content["net"], net, Path(path))
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
        sizes=content.get("sizes"),
        origin=content.get("origin", torch.zeros(3, dtype=torch.float64)),
    )


def load(
    path: str | Path, cache: Cache | None = DEFAULT, net: Callable | None = None, workers: int | None = None
) -> Trained:
    """A trained model from the best.ckpt of a regression, classification or reconstruction.

    Args:
        path: the file.
        cache: where the eigenbases of its training shapes are looked up, and those of new shapes kept.
        net: the class of its net, if that is none of `lssd_learn.nets` and of no plug-in.
        workers: processes, see `in_parallel`.

    Raises:
        InputError: no checkpoint, or one that lacks what it takes to read new shapes.
    """
    return read_trained(Path(path).expanduser(), net, cache, list(HOLDS), workers)


def _make(described: dict) -> Collection:
    """The collection of a configuration, of our own or of a package that may be named: see `find_class`."""
    given = {name: _make(value) if _is_node(value) else value for name, value in described.items()}
    path = str(given.pop("_target_", "nothing"))
    what = "ckpt_path: the checkpoint names a collection"
    own = path.rpartition(".")[2] if path.startswith("lssd_learn.") else ""
    kind = getattr(collections, own) if own in collections.__all__ else find_class(path, Collection, what)
    if not (isinstance(kind, type) and issubclass(kind, Collection)):
        raise InputError(f"{what} {path}: expected one of lssd_learn.collections")
    return kind(**given)


def _is_node(value: Any) -> bool:
    return isinstance(value, dict) and "_target_" in value


def _rebuild(described: list, net: Callable | None, path: Path) -> Callable:
    """A partial of the net that `describe` described: `net` if it is that, one of ours, or as `find_class` has it."""
    target, options = described[0], described[-1]
    name = target.rpartition(".")[2]
    function = None if net is None else unbound(net)
    if function is not None and f"{function.__module__}.{function.__qualname__}" == target:
        return partial(function, **options)
    if target.startswith("lssd_learn.") and name in nets.__all__ and name[0].isupper():
        return partial(getattr(nets, name), **options)
    return partial(find_class(target, nn.Module, f"{path}: its net is"), **options)
