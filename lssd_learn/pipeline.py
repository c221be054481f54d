"""From a collection of shapes to the small matrices everything else works on, each stage cached.

collection → eigenbases → functional map network → latent space → operators
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.checked import ensure_checked
from lssd_learn.collections.clouds import clouds, clouds_key, origin_of
from lssd_learn.collections.eigenbases import StoredBases, basis_keys, eigenbases
from lssd_learn.collections.given import as_collection
from lssd_learn.collections.picking import Picking
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import asked, stack_differences
from lssd_learn.latent.newcomers import push_all
from lssd_learn.maps import PairMaps, VertexMaps
from lssd_learn.maps.needs import ensure_mappable
from lssd_learn.partials import parts, unbound
from lssd_learn.shapes import Eigenbasis
from lssd_learn.trusting import quality_rows, trusted_network

log = logging.getLogger(__name__)

STAGE = "latent"
VERSION = 4  # goes up whenever the same eigenbases and arguments give another latent space


@dataclass(frozen=True)
class Pipeline:
    """The stages as one object; each is computed when first asked for, or read from the cache.

    Args:
        collection: n shapes, a collection or a plain list.
        k: eigenfunctions a shape.
        laplacian: auto, cotangent or robust.
        maps: bases, collection → (i, j) → C_ij; its `is_identity` says that none are needed.
        network: bases → MapNetwork, the topology's own arguments bound; `labels` may name a group of the collection.
        size: consistent functions made canonical.
        keep: of these, the lowest by frequency.
        fitted: positions of the shapes the latent space is fitted to, ascending; the others are pushed into it, as
            shapes that were not there. None fits it to all.
        device: where the latent space is computed, such as "cuda"; it is then kept on the CPU like any other. One of a
            GPU is the same but for rounding, and the cache makes no difference between them.
        cache: None computes everything anew.
        workers: processes for the work that goes shape by shape; see `in_parallel`.
        remedy: the command that would make missing eigenbases again.
    """

    collection: Collection
    k: int = 80
    laplacian: str = "auto"
    maps: Callable[..., PairMaps] = VertexMaps
    network: Callable[..., MapNetwork] = MapNetwork.clique
    size: int = 64
    keep: int = 40
    fitted: Sequence[int] | np.ndarray | None = None
    device: str = "cpu"
    cache: Cache | None = DEFAULT
    workers: int | None = None
    remedy: str = ""

    def __post_init__(self):
        object.__setattr__(self, "collection", as_collection(self.collection))  # frozen: the only door
        check_whole("basis.k", self.k, 1)
        if self.workers is not None:
            check_whole("parallel.workers", self.workers, 1)
        self.collection.keep_in(self.cache, self.workers)
        for name, value, most, what in (("size", self.size, self.k, "k"), ("keep", self.keep, self.size, "size")):
            if not 1 <= value <= most:
                raise InputError(f"latent.{name}={value}: expected 1 to {what}={most}")
        try:
            torch.empty(0, device=self.device)
        except (AssertionError, RuntimeError):
            there = "cpu, cuda" if torch.cuda.is_available() else "cpu; torch finds no GPU"
            raise InputError(f"latent.device={self.device}: expected a device of this machine: {there}") from None
        if self.fitted is not None:
            object.__setattr__(self, "fitted", tuple(map(int, self.fitted)))

    def __repr__(self) -> str:
        how = f"{getattr(unbound(self.maps), '__name__', self.maps)}, k={self.k}, size={self.size}, keep={self.keep}"
        return f"Pipeline({self.collection!r}, {how})"

    @cached_property
    def bases(self) -> Picking[Eigenbasis]:
        """n eigenbases. Those of a cached latent space are opened only when one is asked for."""
        bases = eigenbases(self.collection, self.k, self.laplacian, self.cache, self.workers, self._check_maps)
        return self._stored if isinstance(bases, StoredBases) else bases

    @cached_property
    def latent(self) -> LatentSpace:
        """The canonical latent space of the collection, cut to `keep` functions."""
        return self.whole.with_keep(self.keep)

    @cached_property
    def whole(self) -> LatentSpace:
        """The same with all of its `size` functions."""
        if self.cache is None or self.collection.key is None:
            return self._fit()
        ensure_checked(self.collection, self.cache)
        arrays = self.cache.get(STAGE, self.keys["latent"], lambda: _to_arrays(self._fit()))
        tensors: dict[str, Any] = {name: torch.tensor(array) for name, array in arrays.items()}
        space = LatentSpace(**tensors, bases=self._stored, names=tuple(self.collection.names))
        return space if self.fitted is None else space.averaging(self.fitted)

    def operators(self, kinds: Sequence[str] = ("area",)) -> Float[Tensor, "n channels keep keep"]:
        """(n, channels, keep, keep) float64: some of `DIFFERENCES`, conformal ones in their symmetric form."""
        kinds = tuple(kinds)
        if kinds not in self._operators:
            if "moments" in asked(kinds) and isinstance(self.latent.bases, StoredBases):
                self.latent.bases.measure(self.workers, before=lambda: self.bases)
            self._operators[kinds] = stack_differences(self.latent, kinds)
        return self._operators[kinds]

    @cached_property
    def _operators(self) -> dict[tuple[str, ...], Tensor]:
        """Those asked for so far: a run asks for the same again and again."""
        return {}

    def clouds(
        self, points: int, seed: int = 0, origin: Float[np.ndarray, "3"] | None = None
    ) -> Float[np.ndarray, "n points 3"]:
        """(n, points, 3) float32: one fixed area-uniform sample a shape, about `origin`, by default its own."""
        origin = self.origin if origin is None else origin
        return clouds(self.collection, points, seed, self.cache, self.workers, origin)

    @cached_property
    def origin(self) -> Float[np.ndarray, "3"]:
        """(3,) what is taken off the clouds of shapes far from zero, so that float32 has digits for them."""
        return origin_of(self.collection, self.cache)

    @cached_property
    def keys(self) -> dict[str, str]:
        """What the cache knows the inputs of a run by; empty for a collection without a key."""
        if self.collection.key is None:
            return {}
        how = [self.described_maps, self._maps_key, describe(self.network), self.labels]
        shapes = [self._basis_keys] if self.fitted is None else [self._basis_keys, list(self.fitted)]
        latent = fingerprint(STAGE, VERSION, *shapes, how, self.size)
        return {"collection": self.collection.key, "eigenbases": fingerprint(self._basis_keys), "latent": latent}

    def clouds_key(self, points: int, seed: int = 0) -> str:
        """The cache's key of the clouds."""
        return clouds_key(self.collection, points, seed, self.origin)

    def with_keep(self, keep: int) -> "Pipeline":
        """The same pipeline with another number of functions; it shares everything cached."""
        return replace(self, keep=keep)

    @property
    def _stored(self) -> StoredBases:
        names, shapes = self.collection.names, self.collection.__getitem__
        return StoredBases(cast(Cache, self.cache), self._basis_keys, names, self.remedy, shapes)

    @cached_property
    def _basis_keys(self) -> list[str]:
        return basis_keys(self.collection, self.k, self.laplacian)

    @cached_property
    def labels(self) -> list[str] | None:
        """The labels of the group that the topology asks for by name."""
        name = getattr(self.network, "keywords", {}).get("labels")
        if not isinstance(name, str | int | float):
            return None
        name = str(name)  # 2024 is a name too
        if name not in self.collection.groups:
            known = ", ".join(self.collection.groups) or "none"
            raise InputError(f"network.labels={name}: expected a group of the collection; it has {known}")
        return [str(label) for label in self.collection.groups[name]]

    def pair_maps(self) -> PairMaps:
        """The maps of the collection; what they compute of a pair is kept in the cache."""
        maps = self.maps(self.bases, self.collection)
        if self.cache is not None and self.collection.key is not None:
            keys, how = self._basis_keys, self.described_maps
            maps.keep_in(self.cache, lambda i, j, more: fingerprint("vertex_maps", how, keys[i], keys[j], more))
        return maps

    def _check_maps(self) -> None:
        """Whether there is what the maps need."""
        if check := getattr(unbound(self.maps), "check", None):
            every_pair = unbound(self.network) == MapNetwork.clique
            check(self.collection, every_pair=every_pair, **parts(self.maps)[2])

    @cached_property
    def described_maps(self) -> list:
        """`maps`, and the version of what it does, in plain words for a cache key."""
        kind = unbound(self.maps)
        name, *arguments, chosen = describe(self.maps)
        if hasattr(kind, "defaults") and not arguments:  # a choice left out is the default, said or not
            chosen = kind.defaults() | chosen
        version = getattr(kind, "version", None)
        return [name, *arguments, chosen, *([] if version is None else [version])]

    @property
    def computes_maps(self) -> bool:
        """Whether maps are computed where shapes do not correspond; if not, they have to be given."""
        return getattr(unbound(self.maps), "computed", True)

    @property
    def in_order(self) -> bool:
        """Whether the network joins each shape to the next, so that the collection is a sequence."""
        return getattr(unbound(self.network), "in_order", False)

    @property
    def _maps_key(self) -> str | None:
        """Given vertex maps and landmarks change the network; the collection's key covers them."""
        return self.collection.key if self.collection.vertex_maps or self.collection.landmarks else None

    def map_network(self, some: Sequence[int] | np.ndarray | None = None) -> MapNetwork:
        """The functional map network of some of the shapes, None is all, the maps of its edges computed."""
        return self._network(range(len(self.collection)) if some is None else some)

    def _network(self, fitted: Sequence[int] | np.ndarray) -> MapNetwork:
        """The network of some of the shapes."""
        ensure_mappable(self.maps, self.collection)
        n, maps = len(self.collection), self.pair_maps()
        if len(fitted) < 2:
            raise InputError(f"collection: expected 2 shapes or more, got {len(fitted)}")
        if len(fitted) < n and not maps.is_identity:
            raise InputError(
                "data.protocol: expected shapes of the same faces, since those left out are pushed by them"
            )
        network = self._joined(fitted, None if maps.is_identity else maps)
        if maps.is_identity:
            return network
        maps.prepare(network.pairs().tolist(), self.workers)
        return trusted_network(network, maps, [self.collection.names[i] for i in fitted])

    def map_qualities(self) -> list[dict[str, object]]:
        """What is known of the computed maps of the network, a row a map, the worst first; see `quality_rows`."""
        if not self.computes_maps or "latent" not in vars(self):  # a run that asked for none
            return []
        maps = self.pair_maps()
        if maps.is_identity:
            return []
        return quality_rows(self._joined(range(len(self.collection)), maps), maps, self.collection.names)

    def _joined(self, some: Sequence[int] | np.ndarray, maps: PairMaps | None) -> MapNetwork:
        """The chosen topology on some of the shapes."""
        arguments = {} if self.labels is None else {"labels": [self.labels[int(i)] for i in some]}
        return self.network(self.bases[some], maps=maps, **arguments)

    def _fit(self) -> LatentSpace:
        n = len(self.collection)
        fitted = range(n) if self.fitted is None else self.fitted
        network = self._network(fitted)
        edges = network.n * (network.n - 1) // 2 if network.edges is None else len(network.edges)
        log.info("network of %d shapes and %d edges; latent space of %d functions", network.n, edges, self.size)
        names = [self.collection.names[i] for i in fitted]
        space = LatentSpace.fit(network, self.size, self.size, names=names, device=self.device).to("cpu")
        return space if len(fitted) == n else self._with_rest(space, fitted)

    def _with_rest(self, space: LatentSpace, fitted: Sequence[int] | np.ndarray) -> LatentSpace:
        """The space with the shapes it was not fitted to pushed into it, all in the order of the collection."""
        rest = np.setdiff1d(np.arange(len(self.collection)), fitted)
        pushed = push_all(space, self.bases[rest], [self.collection.names[int(i)] for i in rest])
        order = torch.from_numpy(np.argsort(np.concatenate([fitted, rest])))
        Y, evals = torch.cat([space.Y, pushed.Y])[order], torch.cat([space.evals, pushed.evals])[order]
        return space.with_shapes(Y, evals, self.bases, self.collection.names)


def describe(function: Callable) -> list:
    """A function and its bound arguments in plain words, for a cache key.

    Raises:
        InputError: a function without a name, which nobody could tell from another.
    """
    function, arguments, keywords = parts(function)
    name = getattr(function, "__qualname__", "<nameless>")
    if "<" in name:  # <lambda>, <locals>
        raise InputError(
            f"network: expected a function with a name or a partial of one, got {name}; or give cache=None"
        )
    return [f"{function.__module__}.{name}", *map(_plain, arguments), {k: _plain(v) for k, v in keywords.items()}]


def _plain(value):
    """Lists of any make as lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(item) for item in value]
    return value


def _to_arrays(space: LatentSpace) -> dict[str, np.ndarray]:
    names = ("Y", "evals", "spectrum", "U", "energy")
    return {name: getattr(space, name).numpy() for name in names}
