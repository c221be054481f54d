"""A trained reconstruction that draws what algebra on operators makes: analogies, paths.

Operators of shapes the checkpoint was trained with are its own; those of others are pushed into its latent space.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.cache import Cache
from lssd_learn.collections.base import Collection
from lssd_learn.collections.chosen import Chosen
from lssd_learn.collections.eigenbases import StoredBases, basis_keys
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.posed import Posed
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.differences import stack_differences
from lssd_learn.learning import Learner
from lssd_learn.models.model import Trained
from lssd_learn.models.trained import read_trained
from lssd_learn.nets import KernelMachine
from lssd_learn.operators import analogy
from lssd_learn.operators.positive import positive_part
from lssd_learn.pipeline import Pipeline

METHODS = ("multiplicative", "log_euclidean", "linear", "additive")


def open_trained(ckpt_path: Path | None, net: Callable, cache: Cache | None, task: str, local: bool = True) -> Trained:
    """The reconstruction in the checkpoint of a run.

    Args:
        ckpt_path: its file.
        net, cache: see `read_trained`.
        task: for messages.
        local: false leaves out the last step of `nets.VertexDecoder`, which knows the poses of the training shapes and
            allows nothing between them.

    Raises:
        InputError: no checkpoint, or one of another task, or of a net that reads clouds.
    """
    if ckpt_path is None:
        raise InputError(f"task={task}: expected ckpt_path=…, the best.ckpt of a task=reconstruction")
    trained = read_trained(ckpt_path, net, cache, ["reconstruction"])
    if trained.latent is None:
        raise InputError(f"{ckpt_path}: expected a net that reads operators, this one reads clouds")
    if not local and hasattr(trained.learner.net, "neighbours"):
        cast(Tensor, trained.learner.net.neighbours).zero_()
    return trained


def choose(collection: Collection, asked: dict[str, str]) -> Chosen:
    """The shapes that were asked for.

    Args:
        collection: whose shapes.
        asked: what it was asked as → the name of a shape, or of a body and a pose, as body_0003:sitting.

    Raises:
        InputError: no such shape.
    """
    return Chosen([_pick(collection, key, str(name)) for key, name in asked.items()])


def _pick(collection: Collection, key: str, name: str) -> tuple[Collection, int]:
    names = list(collection.names)
    if name in names:
        return collection, names.index(name)
    body, _, pose = name.rpartition(":")
    if isinstance(collection, Bodies) and body in names:
        return Posed(collection, [(names.index(body), pose)]), 0
    more = "; of bodies also with a pose, as body_0003:sitting" if isinstance(collection, Bodies) else ""
    raise InputError(f"{key}={name}: expected the name of a shape, {names[0]} to {names[-1]}{more}")


def operators_of(
    trained: Trained, collection: Collection, pipeline: Pipeline, neighbours: int
) -> Float[Tensor, "n channels m m"]:
    """(n, channels, m, m) float64 operators of shapes in the latent space of a trained net.

    Args:
        collection: n shapes.
        pipeline: its cache and workers count.
        neighbours: see `push_all`.

    Raises:
        InputError: a shape that does not correspond to those of the latent space.
    """
    space, keys, known = cast(LatentSpace, trained.latent), [], {}
    if isinstance(space.bases, StoredBases) and collection.key is not None:
        known = {key: i for i, key in enumerate(space.bases.keys)}
        keys = basis_keys(collection, space.evals.shape[1], trained.laplacian)
    inside = {i: known[keys[i]] for i in range(len(collection)) if known and keys[i] in known}
    new = [i for i in range(len(collection)) if i not in inside]
    size = space.keep
    operators = torch.zeros(len(collection), len(trained.operators), size, size, dtype=torch.float64)
    if inside:
        some = list(inside.values())
        operators[list(inside)] = stack_differences(space.some(some), trained.operators).double()
    if new:
        rest = replace(pipeline, collection=Chosen([(collection, i) for i in new]), fitted=None)
        operators[new] = trained.inputs(rest, neighbours).double()
    return operators


def answer(
    learner: Learner,
    method: str,
    A: Float[Tensor, "s channels m m"],
    B: Float[Tensor, "s channels m m"],
    C: Float[Tensor, "s channels m m"],
) -> Float[Tensor, "s N 3"]:
    """The points (s, N, 3) of shapes that are to C what B is to A.

    Args:
        learner: a trained reconstruction.
        method: "multiplicative" and "log_euclidean", see `operators.analogy`; "linear", C + B − A; or "additive", the
            same on the codes of the net, its activations after the first fully connected layer.
        A, B, C: (s, channels, m, m).

    Raises:
        InputError: an unknown method.
    """
    if method == "additive":
        net = cast(Any, learner.net)  # it has a code
        a, b, c = (net.encode(D.to(learner.mean) - learner.mean) for D in (A, B, C))
        return net.decode(c + b - a)
    return draw_points(learner, result(method, A, B, C))


def result(
    method: str,
    A: Float[Tensor, "s channels m m"],
    B: Float[Tensor, "s channels m m"],
    C: Float[Tensor, "s channels m m"],
) -> Float[Tensor, "s channels m m"]:
    """The operators (s, channels, m, m) of an analogy, of any method but "additive"; `answer` says which there are."""
    if method == "linear":
        return C + B - A
    return channelwise(lambda A, B, C: analogy(A, B, C, method), A, B, C)


def draw_points(learner: Learner, operators: Float[Tensor, "s channels m m"]) -> Float[Tensor, "s N 3"]:
    """What a trained net draws (s, N, 3) of operators that algebra has made (s, channels, m, m)."""
    return learner(suited(learner, operators).to(learner.mean))


def suited(learner: Learner, operators: Tensor) -> Tensor:
    """Operators as the net can read them: one that takes logarithms wants them symmetric positive definite."""
    return channelwise(positive_part, operators) if isinstance(learner.net, KernelMachine) else operators


def channelwise(function, *operators: Tensor) -> Tensor:
    """Apply a function of operators (s, m, m) to every channel of (s, channels, m, m): each has its null functions."""
    channels: Sequence[Tensor] = [function(*(D[:, c] for D in operators)) for c in range(operators[0].shape[1])]
    return torch.stack(channels, dim=1)
