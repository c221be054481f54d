"""A trained model as one object: asked of shapes, it answers with parameters, labels or shapes.

Operators of new shapes have to speak the language the net has learnt: they are pushed into the latent space that its
checkpoint carries, from training shapes they are in vertex correspondence with, or that maps are computed to. Nothing
is fitted again. `trained.py` reads one from its file.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import cast

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from lssd_learn.cache import DEFAULT, Cache
from lssd_learn.collections import Collection, as_collection
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.differences import stack_differences
from lssd_learn.latent.sizes import lengths, size_ratios, tell_of_other_sizes
from lssd_learn.latent.strangers import Arrived
from lssd_learn.learning import Learner, predict
from lssd_learn.maps.named import Make, named_maps
from lssd_learn.models.unlike import BEYOND, radii, tell_of_unlike, unlike
from lssd_learn.pipeline import Pipeline
from lssd_learn.pushing import push_into
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.given import Given

Shapes = Sequence[Given] | str | PathLike


@dataclass(frozen=True, eq=False)
class Seen:
    """What a net is to read of n shapes, and how unlike the training shapes they are.

    Attributes:
        inputs: operators (n, channels, m, m) or clouds (n, points, 3).
        size: (n,) how many times larger than the training shapes in the middle; None where nobody knows.
        unlike: (n,) see `unlike`; None of clouds.
        map_quality, trusted_maps: (n,) of the computed maps that a shape was read through, see `Arrived`; None where
            nothing is known of any.
        doubtful: (n,) whether what is read of a shape is not to be trusted: it is of another size, unlike anything
            seen, or its maps are bad.
    """

    inputs: Float[Tensor, "n ..."]
    doubtful: Bool[np.ndarray, " n"]
    size: Float[np.ndarray, " n"] | None = None
    unlike: Float[np.ndarray, " n"] | None = None
    map_quality: Float[np.ndarray, " n"] | None = None
    trusted_maps: Int[np.ndarray, " n"] | None = None

    @property
    def doubts(self) -> dict[str, list]:
        """The columns that tell how far to trust what is read, as far as they are known; "trusted" is 1 or 0."""
        told = {name: getattr(self, name) for name in ("size", "unlike", "map_quality", "trusted_maps")}
        columns = {name: values.tolist() for name, values in told.items() if values is not None}
        return columns | {"trusted": (~self.doubtful).astype(int).tolist()}


@dataclass(frozen=True, eq=False)
class Trained:
    """A trained regression, classification or reconstruction.

    Attributes:
        learner: predicts from raw inputs.
        parameters: the names of what a regression predicts.
        latent: the space of its operators; None if it reads clouds.
        operators: which differences are the channels.
        laplacian: of the eigenbases.
        points: of each cloud; None if it reads operators.
        sizes: (N,) the radii of the clouds it was trained on; None if it reads operators, or nobody knows.
        origin: (3,) what is taken off the points of clouds.
        faces: (F, 3) of the meshes a reconstruction gives; None if it gives clouds.
        known: makes the shapes of the latent space; None where the file does not say which they are.
        group: what a classification tells, and
        classes: the labels of its outputs.
        cache: where eigenbases, maps and clouds are kept.
        workers: processes, see `in_parallel`.
    """

    learner: Learner
    parameters: list[str]
    latent: LatentSpace | None
    operators: list[str]
    laplacian: str
    points: int | None
    faces: Int[Tensor, "F 3"] | None = None
    known: Callable[[], Collection] | None = None
    group: str = ""
    classes: Sequence[str] = ()
    cache: Cache | None = DEFAULT
    workers: int | None = None
    sizes: Float[Tensor, " N"] | None = None
    origin: Float[Tensor, "3"] | None = None

    @property
    def task(self) -> str:
        """ "regression", "classification" or "reconstruction"."""
        return "classification" if self.classes else "regression" if self.parameters else "reconstruction"

    @cached_property
    def collection(self) -> Collection | None:
        """The shapes of the latent space, which it was trained on; None where nobody knows them."""
        return None if self.known is None else self.known()

    def predict(self, shapes: Shapes, maps: str | Make = "auto", **how: int) -> np.ndarray:
        """What a regression or a classification says of shapes.

        Args:
            shapes: n of them: a collection, a folder or a sequence, see `as_collection`.
            maps: how those that correspond to no training shape are mapped, see `named_maps`.
            how: neighbours, mapped, candidates; see `inputs`.

        Returns:
            (n, p) float64 in the order of `parameters`; of a classification (n,) labels, see `probabilities` too.

        Raises:
            InputError: a reconstruction, shapes that cannot be pushed, training eigenbases missing in the cache.
        """
        if self.task == "reconstruction":
            raise InputError("predict: expected a regression or a classification, this is a reconstruction")
        found = self._ask(shapes, maps, how)
        return np.asarray(self.classes)[found.argmax(1)] if self.classes else found

    def probabilities(self, shapes: Shapes, maps: str | Make = "auto", **how: int) -> Float[np.ndarray, "n c"]:
        """(n, c) float64, how sure a classification is of each of its `classes`; arguments as of `predict`."""
        if self.task != "classification":
            raise InputError(f"probabilities: expected a classification, this is a {self.task}")
        return torch.softmax(torch.from_numpy(self._ask(shapes, maps, how)), dim=1).numpy()

    def reconstruct(self, shapes: Shapes, maps: str | Make = "auto", **how: int) -> list[Shape]:
        """What a reconstruction draws of shapes, seen through their operators: meshes or clouds; arguments as of
        `predict`."""
        if self.task != "reconstruction":
            raise InputError(f"reconstruct: expected a reconstruction, this is a {self.task}")
        return self.to_shapes(torch.from_numpy(self._ask(shapes, maps, how)))

    def look(self, pipeline: Pipeline, neighbours: int = 5, mapped: int = 1, candidates: int = 100) -> "Seen":
        """What the net is to read of shapes, as `inputs` has it, and how unlike the training shapes they are."""
        names = list(pipeline.collection.names)
        if self.latent is None:
            origin = np.zeros(3) if self.origin is None else self.origin.numpy()
            clouds = torch.tensor(pipeline.clouds(cast(int, self.points), origin=origin))
            if self.sizes is None:
                return Seen(clouds, np.zeros(len(clouds), dtype=bool))
            ratios, far = size_ratios(radii(clouds), self.sizes)
            tell_of_other_sizes(ratios, far, names)
            return Seen(clouds, far, ratios)
        new = self._pushed(pipeline, neighbours, mapped, candidates)
        operators = stack_differences(new.space, self.operators)
        share, beyond = unlike(operators, stack_differences(self.latent, self.operators))
        tell_of_unlike(beyond, names)
        ratios, far = size_ratios(lengths(new.space.evals), lengths(self.latent.evals))
        known = (None, None) if new.quality is None or np.isnan(new.quality).all() else (new.quality, new.trusted)
        return Seen(operators, far | (beyond > BEYOND) | new.doubtful, ratios, share, *known)

    def inputs(
        self, pipeline: Pipeline, neighbours: int = 5, mapped: int = 1, candidates: int = 100
    ) -> Float[Tensor, "n ..."]:
        """What the net is to read of the shapes of `pipeline`: operators (n, channels, m, m) or clouds (n, points, 3).

        Args:
            pipeline: its collection, maps, cache and workers count. Its maps are asked for only if not all of its
                shapes have the faces of training shapes.
            neighbours: how many training shapes a new one is pushed from that corresponds to them.
            mapped, candidates: of one that does not, see `choose_neighbours`.
        """
        return self.look(pipeline, neighbours, mapped, candidates).inputs

    def _pushed(self, pipeline: Pipeline, neighbours: int, mapped: int, candidates: int) -> Arrived:
        known = None if self.known is None else lambda: cast(Collection, self.collection)
        return push_into(
            cast(LatentSpace, self.latent), known, pipeline, self.laplacian, neighbours, mapped, candidates
        )

    def outputs(self, inputs: Float[Tensor, "n ..."], batch: int = 50) -> Float[np.ndarray, "n ..."]:
        """(n, …) float64: what the net makes of raw inputs, `batch` at a time."""
        return predict(self.learner, inputs, batch)

    def to_shapes(self, points: Float[Tensor, "s N 3"]) -> list[Shape]:
        """Points (s, N, 3) that a reconstruction gave, as meshes if they are vertices, or as clouds."""
        arrays = points.double().numpy()
        if self.faces is None:
            return [PointCloud(array) for array in arrays]
        faces = self.faces.numpy()
        return [Mesh(array, faces) for array in arrays]

    def _ask(self, shapes: Shapes, maps: str | Make, how: dict) -> np.ndarray:
        pipeline = Pipeline(as_collection(shapes), maps=named_maps(maps), cache=self.cache, workers=self.workers)
        return self.outputs(self.inputs(pipeline, **how))

    def __repr__(self) -> str:
        told = {
            "regression": f"{len(self.parameters)} parameters",
            "classification": f"{self.group}: {len(self.classes)} classes",
            "reconstruction": "clouds" if self.faces is None else f"meshes of {len(self.faces):,} faces",
        }[self.task]
        reads = f"clouds of {self.points}" if self.latent is None else f"{'+'.join(self.operators)} operators"
        return f"Trained({self.task} of {told}, {type(self.learner.net).__name__} on {reads})"
