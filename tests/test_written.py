"""Files that a run leaves: whole ones, arrays, tables."""

import numpy as np
import pytest

from lssd_learn.written import whole, write_arrays, write_columns, write_rows


def test_columns_come_in_order_and_what_is_lacking_is_empty(tmp_path):
    write_rows([{"name": "a, b", "mse": 1 / 3}, {"name": "c", "n": 2, "mse": np.float64(1e-9)}], tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text().splitlines() == ["name,mse,n", '"a, b",0.333333,', "c,1e-09,2"]


def test_columns_are_rows_too(tmp_path):
    write_columns({"name": ["a", "ü"], "right": [1, 0]}, tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text(encoding="utf-8").splitlines() == ["name,right", "a,1", "ü,0"]
    with pytest.raises(ValueError, match="shorter"):
        write_columns({"name": ["a", "b"], "right": [1]}, tmp_path / "x.csv")


@pytest.mark.parametrize("before", [None, "old"])
def test_a_file_is_there_whole_or_as_it_was(tmp_path, before):
    path = tmp_path / "x.csv"
    if before is not None:
        path.write_text(before)
    with pytest.raises(ValueError, match="embedded null"), whole(path) as draft:
        draft.with_name(draft.write_text("half") * "\0").touch()
    assert [file.read_text() for file in tmp_path.iterdir()] == ([] if before is None else [before])
    with whole(path) as draft:
        draft.write_text("new")
    assert [file.read_text() for file in tmp_path.iterdir()] == ["new"]


def test_arrays_have_the_same_bytes_and_keep_their_names(tmp_path):
    arrays = {"a": np.arange(3), "a/b": np.array("ü")}
    one, other = write_arrays(arrays, tmp_path / "new" / "one"), write_arrays(arrays, tmp_path / "other.npz")
    assert one == tmp_path / "new" / "one.npz"
    assert one.read_bytes() == other.read_bytes()
    with np.load(one) as found:
        assert {name: found[name].tolist() for name in found} == {"a": [0, 1, 2], "a/b": "ü"}
