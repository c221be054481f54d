"""What a task is given: the configuration, turned into objects once."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lssd_learn.cache import Cache
from lssd_learn.division.options import Data, Debug, TrainerOptions
from lssd_learn.division.protocols import fitted
from lssd_learn.errors import MOST_SEED, InputError, check_positive, check_whole
from lssd_learn.latent.differences import check_kinds
from lssd_learn.nets import is_solved
from lssd_learn.pipeline import Pipeline


@dataclass(frozen=True)
class Pieces:
    """The choices of one run.

    Attributes:
        pipeline: collection, eigenbases, network, latent space, clouds.
        operators: which differences are the channels.
        data: split, batch, points, protocol.
        net: a partial of a net's class.
        learning_rate: of the net; None for one that is solved in closed form.
        trainer: options of Lightning's Trainer.
        debug: epochs, overfit.
        seed: of the split, the first weights, the batch order.
        ckpt_path: a checkpoint to go on from.
        task: (pieces, out) → metrics.
        described: the collection, as the configuration describes it.
        choices: what tells this run from its neighbours, flat: the names of the choices and the numbers that matter.
    """

    pipeline: Pipeline
    operators: list[str]
    data: Data
    net: Callable
    learning_rate: float | None
    trainer: TrainerOptions
    debug: Debug
    seed: int
    ckpt_path: Path | None
    task: Callable
    choices: dict
    described: dict

    @classmethod
    def from_config(cls, config: dict, choices: dict, instantiate: Callable, out: Path, command: str) -> "Pieces":
        """The pieces of a resolved configuration.

        Args:
            config: plain nested dicts.
            choices: group → name of its choice.
            instantiate: makes the object of a node with a `_target_`.
            out: the run's folder.
            command: the command line that makes eigenbases again where they are missing.
        """
        latent, net = dict(config["latent"]), dict(config["net"])
        learning_rate = net.pop("learning_rate")
        net = instantiate(net)
        if not is_solved(net):
            check_positive("net.learning_rate", learning_rate)
        check_whole("seed", config["seed"], 0, MOST_SEED)
        operators, some = latent.pop("operators"), latent.pop("fitted")
        collection, data = instantiate(config["collection"]), Data(**config["data"])
        check_kinds(operators)
        pipeline = Pipeline(
            collection=collection,
            **config["basis"],
            maps=instantiate(config["maps"]),
            network=instantiate(config["network"]),
            **latent,
            fitted=fitted(collection, config["seed"], data, some),
            cache=Cache(config["cache"]),
            workers=config["parallel"]["workers"],
            remedy=command,
        )
        ckpt_path = config["ckpt_path"]
        if ckpt_path == "last":
            ckpt_path = out / "last.ckpt"
        if ckpt_path is not None and not Path(ckpt_path).is_file():
            raise InputError(
                f"ckpt_path={config['ckpt_path']}: expected a checkpoint, but there is no file {str(ckpt_path)!r}"
            )
        return cls(
            pipeline=pipeline,
            operators=operators,
            data=data,
            net=net,
            learning_rate=learning_rate,
            trainer=TrainerOptions(**config["trainer"]),
            debug=Debug(**config["debug"]),
            seed=config["seed"],
            ckpt_path=None if ckpt_path is None else Path(ckpt_path),
            task=instantiate(config["task"]),
            described=config["collection"],
            choices={
                **{group: choices[group] for group in ("collection", "network", "net")},
                **{name: config["basis" if name == "k" else "latent"][name] for name in ("k", "size", "keep")},
                "operators": "+".join(map(str, operators)),
                "seed": config["seed"],
            },
        )
