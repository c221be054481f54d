"""Tables of 100,000 rows: a second or so of the processor each, where types are not checked at run time as in tests."""

import json
import subprocess
import sys

import pytest

TIMED = """
import json, pathlib, sys, time
import numpy as np
from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import read_landmarks
from lssd_learn.collections.reading.names import Names

path, took = pathlib.Path(sys.argv[1]), {}
names = Names([f"shape {i}" for i in range(100_000)])
values = np.random.default_rng(0).uniform(1, 1e6, (100_000, 3))
for cell in ("{:.4f}", "{:.4f} kg", "K{:.0f}a"):
    rows = [",".join([name, *map(cell.format, row)]) for name, row in zip(names.names, values)]
    path.write_text("\\n".join(["name,a,b,c", *rows]))
    begin = time.process_time()
    read_labels(path, names)
    took[f"labels {cell}"] = time.process_time() - begin
for mark in ".,":
    rows = [f"shape {i // 10};{i % 10};" + ";".join(f"{x:.4f}" for x in row).replace(".", mark)
            for i, row in enumerate(values)]
    path.write_text("\\n".join(["name;landmark;x;y;z", *rows]))
    begin = time.process_time()
    table = read_landmarks(path, names)
    took[f"landmarks {mark}"] = time.process_time() - begin
    found = np.array([landmark.point for row in table.rows for landmark in row])
    assert np.array_equal(found, values.round(4)), mark
print(json.dumps(took))
"""


@pytest.mark.slow
def test_tables_of_100_000_rows(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", TIMED, str(tmp_path / "table.csv")], capture_output=True, text=True, check=True
    )
    took = json.loads(run.stdout)
    assert len(took) == 5
    assert took == {what: pytest.approx(1, abs=1) for what in took}  # under 2 s
