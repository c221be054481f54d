"""What the groups `data`, `trainer` and `debug` of the configuration say, with names and types; `conf/` says it too."""

from collections.abc import Sequence
from dataclasses import dataclass

from lssd_learn.division.protocols import Division


@dataclass(frozen=True)
class Data(Division):
    """`data`: how shapes become batches, and who is trained on; each is explained in conf/data/default.yaml."""

    batch: int = 50
    standardise: str = "auto"
    targets: str = "standardised"
    points: int = 1024
    augment: str = "none"
    rehearse: str | None = None
    twins: str = "none"
    twin_shapes: int = 160
    twin_vertices: Sequence[int] = (5000, 8000)
    twin_neighbours: int = 1


@dataclass(frozen=True)
class TrainerOptions:
    """`trainer`: arguments of Lightning's Trainer, by its names and with its defaults."""

    accelerator: str = "cpu"
    devices: int | str | Sequence[int] = 1
    num_nodes: int = 1
    strategy: str = "auto"
    precision: int | str | None = None
    gradient_clip_val: float | None = None
    gradient_clip_algorithm: str | None = None
    accumulate_grad_batches: int = 1


@dataclass(frozen=True)
class Debug:
    """`debug`: epochs at most, and the few shapes that are trained, chosen and tested on alone; None does neither."""

    epochs: int | None = None
    overfit: int | None = None
