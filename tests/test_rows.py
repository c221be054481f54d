"""Tables that tasks leave."""

import numpy as np
import pytest

from lssd_learn.rows import write_columns, write_rows


def test_columns_come_in_order_and_what_is_lacking_is_empty(tmp_path):
    write_rows([{"name": "a, b", "mse": 1 / 3}, {"name": "c", "n": 2, "mse": np.float64(1e-9)}], tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text().splitlines() == ["name,mse,n", '"a, b",0.333333,', "c,1e-09,2"]


def test_columns_are_rows_too(tmp_path):
    write_columns({"name": ["a", "ü"], "right": [1, 0]}, tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text(encoding="utf-8").splitlines() == ["name,right", "a,1", "ü,0"]
    with pytest.raises(ValueError, match="shorter"):
        write_columns({"name": ["a", "b"], "right": [1]}, tmp_path / "x.csv")
