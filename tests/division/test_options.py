"""What `conf/` says by default is what the options of a notebook are, and every key has its place."""

from dataclasses import asdict

import pytest
import yaml

from lssd_learn.app import conf
from lssd_learn.division.options import Data, Debug, TrainerOptions


@pytest.mark.parametrize(
    ("options", "file"), [(Data, "data/default"), (TrainerOptions, "trainer/cpu"), (Debug, "debug/none")]
)
def test_the_defaults_are_those_of_the_configuration(options, file):
    given = yaml.safe_load((conf() / f"{file}.yaml").read_text())
    default = asdict(options())
    if options is TrainerOptions:
        default["precision"] = default["precision"] or "32-true"  # Lightning's own default, by its name
    assert {key: list(default[key]) if isinstance(default[key], tuple) else default[key] for key in given} == given


@pytest.mark.parametrize("file", sorted((conf() / "trainer").glob("*.yaml")), ids=lambda file: file.stem)
def test_every_trainer_is_one_of_the_options(file):
    given = yaml.safe_load(file.read_text())
    given.pop("defaults", None)  # what else it has is another's
    assert vars(TrainerOptions(**given))
