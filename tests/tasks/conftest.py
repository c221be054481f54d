import json

import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.tasks.pieces import Pieces


@pytest.fixture(scope="session")
def pieces_of():
    """A function (out, overrides) → the pieces of a run in that folder; `choices` are those a task speaks of."""

    def make(out, *overrides, **choices):
        with initialize_config_dir(str(conf()), version_base="1.3"):
            config = OmegaConf.to_container(compose("config", overrides=[*map(str, overrides)]), resolve=True)
        choices = dict.fromkeys(("collection", "network", "net"), "") | choices
        out.mkdir(exist_ok=True)
        return Pieces.from_config(config, choices, instantiate, out, "python train.py again")

    return make


@pytest.fixture
def runs_of(pieces_of, tmp_path, monkeypatch):
    """A function (overrides) → a function (more of them) → metrics of a run in `tmp_path`, on a cache of its own."""
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))

    def make(*fixed, **choices):
        def run(*overrides, out=tmp_path):
            pieces = pieces_of(tmp_path, *fixed, *overrides, **choices)
            return pieces.task(pieces, out)

        return run

    return make


@pytest.fixture
def leave_run(tmp_path):
    """A function that leaves what a run leaves: its overrides, and metrics or an error line."""

    def make(name, overrides, metrics, error=None):
        folder = tmp_path / name
        (folder / ".hydra").mkdir(parents=True)
        (folder / ".hydra" / "overrides.yaml").write_text("\n".join(f"- {line}" for line in overrides) + "\n")
        if metrics is not None:
            (folder / "metrics.json").write_text(json.dumps(metrics))
        if error is not None:
            (folder / "error.txt").write_text(error)
        return folder

    return make
