"""A word stays the word that was typed; a number stays a number."""

import pytest

from lssd_learn.app import conf
from lssd_learn.command.typed import as_typed

FOLDER = "collection=folder"


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("hydra.run.dir=2024_05_12", "hydra.run.dir='2024_05_12'"),
        ("hydra.sweep.dir=1e3", "hydra.sweep.dir='1e3'"),
        ("collection.path=2024_05_12", "collection.path='2024_05_12'"),
        ("collection.path=1e3", "collection.path='1e3'"),
        ("collection.path=true", "collection.path='true'"),
        ("collection.path=2024_05,2024_06", "collection.path='2024_05','2024_06'"),
        ("collection.groups=[1_0,age]", "collection.groups=['1_0',age]"),
        ("ckpt_path=1e3", "ckpt_path='1e3'"),
        ("cache=007_1", "cache=007_1"),
        ("collection.path='2024_05_12'", "collection.path='2024_05_12'"),
        ("collection.path=scans/2024_05", "collection.path=scans/2024_05"),
        ("basis.k=1_0", "basis.k=1_0"),
        ("net.learning_rate=1e-3", "net.learning_rate=1e-3"),
        ("latent.fitted=1_0", "latent.fitted=1_0"),
        ("seed=range(0,5)", "seed=range(0,5)"),
        ("task.formula=~ log(size) + poly(age, 2)", "task.formula='~ log(size) + poly(age, 2)'"),
        ("task.formula=~ C(line, Treatment('b'))", r"task.formula='~ C(line, Treatment(\'b\'))'"),
        ("task.formula='~ sex'", "task.formula='~ sex'"),
    ],
)
def test_only_words_get_quotes(typed, expected):
    assert as_typed([FOLDER, typed], conf()) == [FOLDER, expected]
