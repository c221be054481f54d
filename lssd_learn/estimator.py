"""The way from shapes to operators as an estimator of scikit-learn: fitted to some shapes, it reads others.

    make_pipeline(LSSD(k=80, size=64, keep=40), RidgeCV()).fit(shapes, heights).predict(new)

It does what `pipeline.py` does and pushes new shapes into the space it was fitted to, so that a cross-validation never
sees the shapes it is scored on. Eigenbases are cached shape by shape and serve every fold.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike

import numpy as np
import torch
from jaxtyping import Float
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from lssd_learn.cache import DEFAULT, Cache
from lssd_learn.collections import Collection, as_collection
from lssd_learn.collections.eigenbases import basis_keys
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import stack_differences
from lssd_learn.maps.named import Make, named_maps
from lssd_learn.operators.logarithms import logarithm
from lssd_learn.operators.matrices import null_functions
from lssd_learn.operators.vectors import entries
from lssd_learn.pipeline import Pipeline
from lssd_learn.pushing import push_into
from lssd_learn.shapes.given import Given

Shapes = Sequence[Given] | str | PathLike

# As the config group of this name has them; those that want more than a name are given as a partial.
NETWORKS: dict[str, Callable[..., MapNetwork]] = {
    "clique": MapNetwork.clique,
    "nearest_10": partial(MapNetwork.nearest, neighbours=10),
    "nearest_20": partial(MapNetwork.nearest, neighbours=20),
    "hubs": partial(MapNetwork.hubs, hubs=4),
    "spanning_tree": MapNetwork.spanning_tree,
    "chain": MapNetwork.chain,
    "star": MapNetwork.star,
}
FEATURES = ("logarithms", "matrices")


class LSSD(TransformerMixin, BaseEstimator):
    """Latent space shape differences of shapes, as vectors for what learns and as matrices for what looks.

    Shapes are a collection, the path of a folder, or a sequence of what `as_shape` takes (meshes, clouds, trimesh
    objects, (vertices, faces), paths). Those that share their faces are mapped by vertex identity.

    Args:
        k: eigenfunctions a shape.
        size: consistent functions made canonical, at most k.
        keep: of these, the lowest by frequency.
        network: a name of `NETWORKS`, or a function bases → MapNetwork, such as partial(MapNetwork.nearest,
            neighbours=5).
        operators: which differences, some of "area", "conformal", "extrinsic" and those that plug-ins add.
        features: what `transform` gives. "logarithms": the entries of the logarithms of the operators, which add up
            (log-Euclidean); of conformal ones without the constant, which is null and stays zero. "matrices": those of
            the operators. Both are weighed so that inner products of vectors are those of the matrices.
        maps: how shapes without a common vertex numbering are mapped, a name of `lssd_learn.maps.MAPS` or a class of
            maps.
        laplacian: "auto", "cotangent" or "robust".
        neighbours: shapes of the space that a new one is pushed from, if it has their faces.
        cache: "auto" is the default cache, a path or a `Cache` another; None computes everything anew.
        workers: processes for the work that goes shape by shape; None decides by how long it takes.

    Attributes:
        latent_: the `LatentSpace` of the shapes it was fitted to.
        collection_: these shapes.

    Raises:
        InputError: (a ValueError) arguments out of range, shapes that cannot be used.

    Examples:
        >>> import lssd_learn as lssd
        >>> spheres = list(lssd.collections.Bumps(subdivisions=2))
        >>> reader = lssd.LSSD(k=12, size=9, keep=4, network="clique", cache=False).fit(spheres)
        >>> reader.transform(spheres).shape
        (4, 20)
    """

    def __init__(
        self,
        k: int = 80,
        size: int = 64,
        keep: int = 40,
        network: str | Callable[..., MapNetwork] = "clique",
        operators: Sequence[str] = ("area", "conformal"),
        features: str = "logarithms",
        maps: str | Make = "auto",
        laplacian: str = "auto",
        neighbours: int = 5,
        cache: Cache | str | PathLike | None = "auto",
        workers: int | None = None,
    ):
        self.k = k
        self.size = size
        self.keep = keep
        self.network = network
        self.operators = operators
        self.features = features
        self.maps = maps
        self.laplacian = laplacian
        self.neighbours = neighbours
        self.cache = cache
        self.workers = workers

    def fit(self, X: Shapes, y=None) -> "LSSD":
        """The latent space of shapes X, two or more. y is not looked at."""
        if self.features not in FEATURES:
            raise InputError(f"features={self.features!r}: expected one of {', '.join(FEATURES)}")
        pipeline = self._pipeline(as_collection(X))
        latent = pipeline.latent
        stack_differences(latent, self.operators)  # refuses operators that do not exist
        self.latent_: LatentSpace = replace(latent, bases=pipeline.bases)
        self.collection_: Collection = pipeline.collection
        return self

    def transform(self, X: Shapes) -> Float[np.ndarray, "n d"]:
        """(n, d) float64, see `features`; d = m (m + 1) / 2 an operator of m = `keep` functions."""
        channels = torch.from_numpy(self.matrices(X)).unbind(1)
        if self.features == "logarithms":
            fitted = stack_differences(self.latent_, self.operators).unbind(1)
            channels = [logarithm(D, null_functions(seen)) for D, seen in zip(channels, fitted, strict=True)]
        return torch.cat([entries(D) for D in channels], dim=1).numpy()

    def matrices(self, X: Shapes) -> Float[np.ndarray, "n channels m m"]:
        """(n, channels, m, m) float64: the operators of shapes X, conformal ones in their symmetric form.

        Shapes that it was fitted to have those of the fitted space; others are pushed into it.
        """
        check_is_fitted(self)
        collection = as_collection(X)
        if not len(collection):
            raise InputError("shapes: expected one or more, got none")
        space = self.latent_
        known = {key: i for i, key in enumerate(self._keys(self.collection_))}
        inside = {i: known[key] for i, key in enumerate(self._keys(collection)) if key in known}
        found = torch.empty(len(collection), len(self.operators), space.keep, space.keep, dtype=torch.float64)
        if inside:
            some = list(inside.values())
            found[list(inside)] = stack_differences(space.some(some), self.operators)
        if new := [i for i in range(len(collection)) if i not in inside]:
            rest = collection if len(new) == len(collection) else collection[new]
            new_ones = push_into(space, lambda: self.collection_, self._pipeline(rest), self.laplacian, self.neighbours)
            found[new] = stack_differences(new_ones.space, self.operators)
        return found.numpy()

    def get_feature_names_out(self, input_features=None) -> np.ndarray:
        """(d,) texts, as area_0_3: the operator, row and column of each entry."""
        check_is_fitted(self)
        rows, columns = np.triu_indices(self.latent_.keep)
        of = {"logarithms": "log_", "matrices": ""}[self.features]
        return np.array([f"{of}{kind}_{i}_{j}" for kind in self.operators for i, j in zip(rows, columns, strict=True)])

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.two_d_array, tags.no_validation = False, True  # shapes, checked by `as_collection`
        return tags

    def _keys(self, collection: Collection) -> list[str]:
        """What tells its shapes from others; nothing where nothing does."""
        return [] if collection.key is None else basis_keys(collection, self.k, self.laplacian)

    def _pipeline(self, collection: Collection) -> Pipeline:
        network = self.network
        if not callable(network):
            if network not in NETWORKS:
                raise InputError(f"network={network!r}: expected one of {', '.join(NETWORKS)}, or a function of bases")
            network = NETWORKS[network]
        cache = DEFAULT if self.cache == "auto" else self.cache
        return Pipeline(
            collection,
            self.k,
            self.laplacian,
            named_maps(self.maps),
            network,
            self.size,
            self.keep,
            cache=cache if cache is None or isinstance(cache, Cache) else Cache(str(cache)),
            workers=self.workers,
        )
