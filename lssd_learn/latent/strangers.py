"""New shapes in an old latent space that correspond to none of its shapes: maps are computed to a few of these."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from jaxtyping import Bool, Float, Int

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections import Collection, ShapeList, StoredBases, clouds, eigenbases
from lssd_learn.collections.chosen import Chosen
from lssd_learn.collections.clouds import origin_of
from lssd_learn.errors import InputError, check_whole, some_of
from lssd_learn.latent.graphs.lacking import lacking
from lssd_learn.latent.sizes import tell_of_sizes_in
from lssd_learn.latent.space import LatentSpace
from lssd_learn.maps import PairMaps
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.span.mixtures import Starts, mixtures
from lssd_learn.maps.span.spanned import Spanned
from lssd_learn.progress import track
from lssd_learn.shapes import Eigenbasis, Mesh
from lssd_learn.shapes.nearest import Indexed

log = logging.getLogger(__name__)

LIKE = 5  # shapes that a mixture is pushed from
SPARE = 2  # more neighbours, to begin a mixture from
POINTS = 512  # of each shape, to see which ones stand in the same pose
AXES = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])  # the turns that leave principal axes in place


@dataclass(frozen=True, eq=False)
class Arrived:
    """New shapes in an old latent space, and how far the maps that brought them there are to be trusted.

    Attributes:
        space: of the m new shapes alone, see `push_all`.
        quality: (m,) the median quality of the computed maps that each was pushed through, NaN where nothing is known
            of them; None where none were computed.
        trusted: (m,) how many of these maps can be trusted.
        level: the quality from which they can.
        unfit: (m,) whether a shape that may lie anyhow came through maps of which nothing is known, as it is no mixture
            of known ones; None where none did.
    """

    space: LatentSpace
    quality: Float[np.ndarray, " m"] | None = None
    trusted: Int[np.ndarray, " m"] | None = None
    level: float = 0.0
    unfit: Bool[np.ndarray, " m"] | None = None

    @property
    def doubtful(self) -> Bool[np.ndarray, " m"]:
        """(m,) whether a shape came through maps that are not to be trusted."""
        if self.quality is None:
            return np.zeros(len(self.space), dtype=bool)
        bad = self.quality < self.level  # NaN is not
        return bad if self.unfit is None else bad | self.unfit


def push_strangers(
    space: LatentSpace,
    known: Collection,
    strangers: Collection,
    bases: Sequence[Eigenbasis],
    maps: Callable[..., PairMaps],
    neighbours: int = 1,
    candidates: int = 100,
    cache: Cache | None = None,
    workers: int | None = None,
    described: Sequence = (),
    own: Sequence[int] | None = None,
) -> Arrived:
    """The new shapes in the language of `space`, each pushed by least squares through computed maps.

    See `choose_neighbours` for the shapes that are mapped. Of several maps those that are not to be trusted are left
    out, where there are others.

    A map by itself is as exact as two unlike shapes allow. Where the known shapes correspond to one another they say
    more: of a new shape that is a mixture of them, see `maps.span`, it is the mixture that is pushed, with its own
    eigenbasis, which corresponds to theirs. The computed map is where it begins; of a cloud a turn is, however it lies,
    and maps are computed only where it turns out to be no mixture. How a shape happens to be meshed then plays no part,
    nor that the Laplacian of a cloud differs from that of a mesh, in conformal operators by several times what shapes
    do. A shape that is a mixture only once it is bent, as of somebody who stands as no known one does, is pushed
    unbent: what was learnt of known shapes holds as they stand.

    Args:
        space: of the shapes of `known`, with their eigenbases of k functions.
        known: n shapes.
        strangers: m new shapes.
        bases: their eigenbases of k functions.
        maps: eigenbases, collection → PairMaps; what the config group `maps` chooses.
        neighbours, candidates: see `choose_neighbours`.
        cache: where maps and clouds are kept; None computes them.
        workers: processes; see `in_parallel`.
        described: `maps` in plain words, for the cache.
        own: (m,) the known shape that each new one was made of and is not to be mapped to; None where there is none.

    Raises:
        InputError: numbers out of their range, shapes that `maps` cannot map.
    """
    n, pushed = len(known), []
    both = Chosen([(known, i) for i in range(n)] + [(strangers, j) for j in range(len(strangers))])
    old = space.bases
    if old is None:
        raise InputError("this latent space was loaded without its eigenbases, to which new shapes are mapped")
    pair_maps = maps(_Joined(old, bases), both)
    pair_maps.known, turned = n, pair_maps.turned
    near = choose_neighbours(space, known, strangers, bases, neighbours, candidates, cache, workers, own, turned, SPARE)
    chosen = [some[:neighbours] for some in near]
    if cache is not None and both.key is not None and isinstance(old, StoredBases) and isinstance(bases, StoredBases):
        keys, how = [*old.keys, *bases.keys], list(described)
        pair_maps.keep_in(cache, lambda i, j, more: fingerprint("vertex_maps", how, keys[i], keys[j], more))
    meshes = [j for j in range(len(bases)) if bases[j].connectivity is not None]
    pair_maps.prepare([(i, n + j) for j in meshes for i in chosen[j]], workers)
    mixed = mixtures(
        Starts(known, strangers, old, pair_maps, near, own or [-1] * len(bases)), described, cache, workers
    )
    fit = {j: one for j, one in enumerate(mixed) if one is not None and one.fits}
    needed = [j for j in range(len(bases)) if j in meshes or j not in fit]
    edges = np.array([(i, n + j) for j in needed for i in chosen[j]], dtype=int).reshape(-1, 2)
    pair_maps.prepare([(i, j) for i, j in edges.tolist() if j - n not in meshes], workers)
    unreached = [pair_maps.unreached(i, j) for i, j in edges.tolist()]
    if few := [i - n for i in lacking(n + len(bases), edges, unreached) if i >= n]:
        log.warning(
            "%d of %d shapes seem to lack a part that the training shapes have, or to be of another kind: %s",
            len(few), len(bases), some_of([strangers.names[j] for j in few]),
        )  # fmt: skip
    if fit:
        log.info("%d of %d shapes are mixtures of the training shapes, and pushed as such", len(fit), len(bases))
        if bent := sum(bool(one.bent) for one in fit.values()):
            log.info("%d of them once they are bent: these are read as if they stood as training shapes do", bent)
        bases = _of_mixtures(bases, fit, known, cache, workers)
    if lost := [strangers.names[j] for j, one in enumerate(mixed) if one is not None and not one.fits]:
        log.info(
            "%d of %d are no mixtures, and read through maps alone, less well: %s", len(lost), len(bases), some_of(lost)
        )
    qualities, counts = [], []
    for j, some in enumerate(track(chosen, "pushing")):
        told = [pair_maps.quality(i, n + j) if j in needed else None for i in some]
        known_of = np.array([np.nan if quality is None else quality for quality in told])
        good = ~(known_of < pair_maps.level)
        used = good if good.any() else ~good
        if j in fit:
            maps_to = {i: tuple(from_correspondence(*way) for way in ((old[i], bases[j]), (bases[j], old[i])))
                       for i in fit[j].shapes[:LIKE].tolist()}  # fmt: skip
        else:
            maps_to = {i: (pair_maps(i, n + j), pair_maps(n + j, i)) for i, use in zip(some, used, strict=True) if use}
        pushed.append(space.push(bases[j], maps_to).basis)
        qualities.append(float(np.median(known_of[used])))
        counts.append(int(good.sum()))
    evals = torch.tensor(np.stack([np.asarray(basis.evals) for basis in bases])).to(space.evals)
    new = space.with_shapes(torch.stack(pushed), evals, bases, strangers.names)
    tell_of_sizes_in(space, new)
    tried = np.array([turned and one is not None and not one.fits for one in mixed])
    unfit = tried & np.isnan(qualities)
    return Arrived(new, np.array(qualities), np.array(counts), pair_maps.level, unfit)


def choose_neighbours(
    space: LatentSpace,
    known: Collection,
    strangers: Collection,
    bases: Sequence[Eigenbasis],
    neighbours: int = 1,
    candidates: int = 100,
    cache: Cache | None = None,
    workers: int | None = None,
    own: Sequence[int] | None = None,
    turned: bool = False,
    spare: int = 0,
) -> list[list[int]]:
    """For each new shape the shapes of `space` to map it to, the nearest first.

    Of the `candidates` nearest by Shape-DNA those whose points lie nearest to its own, both centred. Between shapes of
    one pose and nearly one build maps are much the best, and one such neighbour does better than several. As many
    candidates as neighbours leave the choice to Shape-DNA.

    Args:
        turned: shapes lie anyhow: their principal axes are laid over each other, in the best of the four ways.
        spare: so many more than `neighbours`, as far as there are candidates.

    Raises:
        InputError: numbers out of their range.
    """
    check_whole("task.neighbours", neighbours, 1, len(known))
    check_whole("task.candidates", candidates, neighbours)
    own = [-1] * len(bases) if own is None else own
    near = [
        [i for i in space.neighbours(np.asarray(basis.evals), min(candidates + 1, len(known))) if i != itself]
        for basis, itself in zip(bases, own, strict=True)
    ]
    near = [some[:candidates] for some in near]
    if candidates == neighbours:
        return near
    return lying_alike(known, strangers, near, neighbours + spare, cache, workers, turned)


def lying_alike(
    known: Collection,
    strangers: Collection,
    near: Sequence[Sequence[int]],
    count: int,
    cache: Cache | None = None,
    workers: int | None = None,
    turned: bool = False,
) -> list[list[int]]:
    """For each new shape so many of the known ones in `near`, those first whose points lie nearest to its own.

    Args:
        turned: see `choose_neighbours`.
    """
    lay = _on_axes if turned else _centred
    ours, theirs = (lay(clouds(c, POINTS, 0, cache, workers, origin_of(c, cache))) for c in (known, strangers))
    known_clouds = {i: Indexed(ours[i]) for i in set().union(*near)}
    chosen = []
    for points, some in zip(theirs, track(near, "choosing neighbours"), strict=True):
        ways = [Indexed(points * signs) for signs in (AXES if turned else AXES[:1])]
        away = [min(cloud.chamfer(known_clouds[i]) for cloud in ways) for i in some]
        chosen.append([some[place] for place in np.argsort(away, kind="stable")[:count]])
    return chosen


def _of_mixtures(
    bases: Sequence[Eigenbasis], fit: dict[int, Spanned], known: Collection, cache: Cache | None, workers: int | None
) -> list[Eigenbasis]:
    """The eigenbases of new shapes, those of some replaced by those of the mixtures that they are."""
    meshes = [Mesh(one.points, cast(Mesh, known[int(one.shapes[0])]).faces) for one in fit.values()]
    new = eigenbases(ShapeList(meshes), bases[0].k, cache=cache, workers=workers)
    number = {j: place for place, j in enumerate(fit)}
    return [new[number[j]] if j in number else bases[j] for j in range(len(bases))]


class _Joined(Sequence[Eigenbasis]):
    """The eigenbases of two collections one after the other, opened when asked for."""

    def __init__(self, first: Sequence[Eigenbasis], second: Sequence[Eigenbasis]):
        self._first, self._second = first, second

    def __len__(self) -> int:
        return len(self._first) + len(self._second)

    def __getitem__(self, i: int) -> Eigenbasis:
        return self._first[i] if i < len(self._first) else self._second[i - len(self._first)]


def _centred(points: np.ndarray) -> np.ndarray:
    return points - points.mean(axis=1, keepdims=True)


def _on_axes(points: np.ndarray) -> np.ndarray:
    """Each cloud of (n, N, 3) centred and turned so that it is longest along x, then y; not mirrored."""
    points = _centred(points)
    axes = np.linalg.eigh(np.swapaxes(points, 1, 2) @ points)[1][:, :, ::-1].copy()
    axes[:, :, 2] *= np.linalg.det(axes)[:, None]
    return points @ axes
