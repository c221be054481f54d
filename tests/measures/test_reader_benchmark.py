from types import SimpleNamespace

import numpy as np
import pytest

from lssd_learn.collections import Bodies, People
from lssd_learn.collections.anthropometry.measures import NAMES
from lssd_learn.errors import InputError
from lssd_learn.measures import reader_benchmark
from lssd_learn.measures.rivals.pointnet import read_by_net
from lssd_learn.measures.rivals.sections import read_by_sections
from lssd_learn.models.measuring import BodyReader


def pieces_of_scans(collection):
    return SimpleNamespace(pipeline=SimpleNamespace(collection=collection))


def test_every_rival_is_asked_and_none_is_better_than_the_reader(tmp_path):
    people = People(n=2, seed=950)
    metrics = reader_benchmark.run(pieces_of_scans(people), tmp_path, people=24, epochs=2, inverted=1)
    assert set(metrics) == {f"l1/{name}" for name in ("reader", "mean", "net", "sections", "inverter", "inverter_true")}
    assert min(metrics, key=metrics.__getitem__) == "l1/reader"
    header, *rows = (tmp_path / "rivals.csv").read_text().splitlines()
    assert header == "measure,reader,mean,net,sections,inverter,inverter_true"
    assert [row.split(",")[0] for row in rows] == list(NAMES)
    with pytest.raises(InputError, match="expected people whose measures are known"):
        reader_benchmark.run(pieces_of_scans(Bodies(n=2)), tmp_path)


def test_sections_of_a_person_who_stands_upright_are_about_the_girths():
    people, reader = People(n=2, seed=951), BodyReader.load()
    body = people.make(people.sliders[0], "rest")
    read = dict(zip(NAMES, read_by_sections(reader, body, np.array([0.0, 0, 1])), strict=True))
    truth = dict(zip(NAMES, people.parameters[0], strict=True))
    assert read["height_mm"] == pytest.approx(truth["height_mm"], rel=0.02)
    assert read["area_m2"] == pytest.approx(truth["area_m2"], rel=5e-3)
    for part in ("waist", "hip", "chest"):
        assert read[f"{part}_girth_mm"] == pytest.approx(truth[f"{part}_girth_mm"], rel=0.15)


def test_the_net_reads_the_same_each_time():
    shapes = list(People(n=2, seed=952, topology="notoes_collapse5pc"))
    one, other = (read_by_net(shapes, 8, 1) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    assert one.shape == (2, len(NAMES))
