"""Tables of 100,000 rows: a second or so of the processor each."""

import time

import numpy as np
import pytest

from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import read_landmarks
from lssd_learn.collections.reading.names import Names


@pytest.mark.parametrize("cell", ["{:.4f}", "{:.4f} kg", "K{:.0f}a"])
def test_a_table_of_100_000_rows(cell, tmp_path):
    names = [f"shape {i}" for i in range(100_000)]
    values = np.random.default_rng(0).uniform(1, 1e6, (len(names), 3))
    path = tmp_path / "labels.csv"
    rows = [",".join([name, *map(cell.format, row)]) for name, row in zip(names, values, strict=True)]
    path.write_text("\n".join(["name,a,b,c", *rows]))
    known, begin = Names(names), time.process_time()
    labels = read_labels(path, known)
    assert time.process_time() - begin < 2
    assert len(labels.groups["a"] if labels.parameters is None else labels.parameters) == len(names)


@pytest.mark.parametrize("mark", [".", ","])
def test_landmarks_of_100_000_rows(mark, tmp_path):
    names = [f"shape {i}" for i in range(10_000)]
    points = np.random.default_rng(0).random((100_000, 3))
    rows = [f"shape {i // 10};{i % 10};" + f"{x:.5f};{y:.5f};{z:.5f}".replace(".", mark) for i, (x, y, z) in
            enumerate(points)]  # fmt: skip
    path = tmp_path / "landmarks.csv"
    path.write_text("name;landmark;x;y;z\n" + "\n".join(rows))
    begin = time.process_time()
    table = read_landmarks(path, names)
    assert time.process_time() - begin < 2
    np.testing.assert_allclose([landmark.point for row in table.rows for landmark in row], points.round(5))
