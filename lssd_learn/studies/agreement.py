"""`task=agreement`: do computed maps show the same difference between groups as true ones?

The same comparison twice: with the maps of the run, and with the vertex correspondence of the same shapes, which the
first does not know (`maps.correspondence=none`, or clouds of a collection that knows their meshes).
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from torch import Tensor
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import ChosenGroups, choose_groups
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration import cross_collection, evidence, local_evidence
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.scores import correlation
from lssd_learn.kdtree import cKDTree
from lssd_learn.latent import LatentSpace
from lssd_learn.maps import VertexMaps
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import PointCloud
from lssd_learn.studies.agreement_chart import agreement_chart
from lssd_learn.view.coloured import save_coloured
from lssd_learn.view.fields import Field, unit_of_change
from lssd_learn.view.scenes import add_row

log = logging.getLogger(__name__)

HIGHLIGHTS = ("region", "function")


@dataclass(frozen=True)
class _Comparison:
    """The groups seen through one set of maps: `region` (m, m) of `evidence` and the best `function` (m,)."""

    latent: LatentSpace
    region: Tensor
    function: Tensor

    @classmethod
    def of(cls, latent: LatentSpace, D: Tensor, groups: ChosenGroups, labels: Sequence | None = None) -> "_Comparison":
        """With `labels` in place of those of the groups, if given."""
        labels = groups.of if labels is None else labels
        some = D[groups.shapes]
        return cls(latent, evidence(some, labels), cross_collection(some, labels))

    def highlight(self, name: str, i: int) -> np.ndarray:
        """(V,) one of `HIGHLIGHTS` on shape i, both squares: what task=compare shows, and the best function alone."""
        if name == "region":
            return local_evidence(self.latent, self.region, i).square().cpu().numpy()
        return self.latent.to_shape(self.function, i).square().cpu().numpy()


def run(
    pieces: Pieces,
    out: Path,
    group: str | None = None,
    labels: Sequence[str] = (),
    shown: int = 3,
    relabelled: int = 20,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write agreement.png and coloured shapes, and print how like the two highlights are.

    Args:
        group, labels: see `choose_groups`.
        shown: shapes of each group in the picture.
        relabelled: random groups of the same sizes, of which the agreement is the chance level.
        azimuth: degrees from which the shapes are seen.

    Returns:
        "shapes", and of each kind of operator area/region (what task=compare shows, squared) and area/function (the
        square of the best function): the correlation of the two highlights over the surface, mean over the shapes,
        and its area/region/lowest; area/chance, that of the region computed maps show for random groups and the one
        true maps show for the real ones.

    Raises:
        InputError: as `choose_groups`; maps that know the correspondence, shapes of which none is known.
    """
    check_whole("task.shown", shown, 1)
    check_whole("task.relabelled", relabelled, 0)
    pipeline = pieces.pipeline
    reference = _reference(pipeline)
    groups = choose_groups(pipeline.collection, group, labels)
    places = [_nearest(pipeline.collection, reference.collection, i) for i in groups.shapes]
    operators = [pipe.operators(pieces.operators) for pipe in (reference, pipeline)]
    chosen = _representatives(operators[0], groups, shown)
    found: dict[str, float] = {"shapes": len(groups.shapes)}
    rows = []
    for c, kind in enumerate(pieces.operators):
        true, computed = (
            _Comparison.of(pipe.latent, D[:, c], groups)
            for pipe, D in zip((reference, pipeline), operators, strict=True)
        )
        for name in HIGHLIGHTS:
            both = [
                correlation(true.highlight(name, i)[near], computed.highlight(name, i), pipeline.bases[i].mass)
                for i, near in zip(groups.shapes, places, strict=True)
            ]
            found |= {f"{kind}/{name}": float(np.mean(both)), f"{kind}/{name}/lowest": min(both)}
        if relabelled:
            others = _relabelled(pipeline.latent, operators[1][:, c], groups, relabelled, pieces.seed)
            chance = [
                correlation(true.highlight("region", i)[near], other.highlight("region", i), pipeline.bases[i].mass)
                for other in others
                for i, near in zip(groups.shapes, places, strict=True)
            ]
            found[f"{kind}/chance"] = float(np.mean(chance))
        for title, pipe, side in (("true maps", reference, true), ("computed maps", pipeline, computed)):
            values = [np.sqrt(side.highlight("region", i)) for i in chosen]
            field = Field.positive(f"{kind}_{title.split()[0]}", f"{kind}, {title}", values, unit=unit_of_change(kind))
            rows.append(([pipe.collection[i] for i in chosen], field))

    up = pipeline.collection.up
    titles = [f"{label}\n{pipeline.collection.names[i]}" for i, label in chosen.items()]
    agreement_chart(rows, titles, up, azimuth).savefig(out / "agreement.png")
    (out / "shapes").mkdir(exist_ok=True)
    with SummaryWriter(out / "tensorboard") as writer:
        for shapes, field in rows:
            add_row(writer, f"agreement/{field.name}", shapes, up, field.colours)
            for j, i in enumerate(chosen):
                name = f"{pipeline.collection.names[i]}_{field.name}.ply"
                save_coloured(shapes[j], field.colours(j), out / "shapes" / name, up, {field.name: field.values[j]})
    _tell(found, pieces.operators)
    return found


def _reference(pipeline: Pipeline) -> Pipeline:
    """The same with true maps.

    Raises:
        InputError: nothing would be computed, or the truth is not known.
    """
    maps = pipeline.maps(pipeline.bases, pipeline.collection)
    if maps.is_identity or not pipeline.computes_maps:
        raise InputError("maps: expected computed ones, such as maps=kernel_matching maps.correspondence=none")
    reference = replace(pipeline, collection=getattr(pipeline.collection, "meshes", pipeline.collection))
    reference = replace(reference, maps=VertexMaps)
    if not VertexMaps(reference.bases, reference.collection).is_identity:
        raise InputError("collection: expected shapes whose true correspondence is known, with the same faces")
    return reference


def _nearest(collection: Collection, meshes: Collection, i: int) -> np.ndarray:
    """For each vertex of shape i the same vertex of its mesh; for each point of a cloud, the nearest one."""
    shape = collection[i]
    if not isinstance(shape, PointCloud):
        return np.arange(len(shape.vertices))
    return cKDTree(meshes[i].vertices).query(shape.points)[1]


def _representatives(operators: Tensor, groups: ChosenGroups, shown: int) -> dict[int, str]:
    """Position in the collection → label of the shapes in the picture."""
    chosen = {}
    for label in groups.labels:
        members = groups.members(label)
        chosen |= {int(members[i]): label for i in representatives(operators[members], shown)}
    return chosen


def _relabelled(latent: LatentSpace, D: Tensor, groups: ChosenGroups, count: int, seed: int) -> list[_Comparison]:
    rng = np.random.default_rng(seed)
    orders = [rng.permutation(len(groups.of)) for _ in range(count)]
    return [_Comparison.of(latent, D, groups, [groups.of[i] for i in order]) for order in orders]


def _tell(found: dict[str, float], kinds: Sequence[str]) -> None:
    log.info("correlation of what true and computed maps highlight, mean over %d shapes:", found["shapes"])
    for kind in kinds:
        region, lowest, function = (found[f"{kind}/{name}"] for name in ("region", "region/lowest", "function"))
        log.info("  %s: where the groups differ %.3f, lowest %.3f; best function %.3f", kind, region, lowest, function)
        if f"{kind}/chance" in found:
            log.info("  %s: of random groups %.3f", kind, found[f"{kind}/chance"])
    log.info("agreement.png, coloured shapes in shapes/")
