import csv
import logging

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import read_landmarks
from lssd_learn.collections.reading.names import composed
from lssd_learn.errors import InputError

NAMES = ["a", "b", "c"]


@pytest.fixture
def table(tmp_path):
    def write(text, encoding="utf-8"):
        path = tmp_path / "table.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


def test_numbers_are_parameters_and_words_are_groups(table):
    labels = read_labels(table("name,age,class,mass\nb,2,x,1e-3\nc,3,y,-4\na,1,x,.5\n"), NAMES)
    assert labels.parameter_names == ["age", "mass"]
    np.testing.assert_array_equal(labels.parameters, [[1, 0.5], [2, 1e-3], [3, -4]])
    assert {name: list(values) for name, values in labels.groups.items()} == {"class": ["x", "x", "y"]}


def test_numbers_that_are_groups_stay_as_written(table):
    labels = read_labels(table("name,pose\na,01\nb,2\nc,01\n"), NAMES, groups=["pose"])
    assert labels.parameters is None
    assert labels.parameter_names == []
    assert list(labels.groups["pose"]) == ["01", "2", "01"]


def test_a_mixture_is_a_group_and_the_log_says_so(table, caplog):
    with caplog.at_level(logging.INFO):
        labels = read_labels(table("name,pose\na,1\nb,reference\nc,3\n"), NAMES)
    assert list(labels.groups["pose"]) == ["1", "reference", "3"]
    assert "column 'pose' is not all numbers ('reference')" in caplog.text


def test_what_spreadsheets_do(table):
    labels = read_labels(table('\ufeffname , age\r\n"a", 1\r\n b ,2\r\n\r\nc,3\r\n,\r\n'), NAMES)
    np.testing.assert_array_equal(labels.parameters[:, 0], [1, 2, 3])


words = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1)
words = words.map(str.strip).map(composed).filter(bool)


@given(
    names=st.lists(words, min_size=1, max_size=5, unique=True),
    data=st.data(),
)
def test_what_is_written_is_read(tmp_path_factory, names, data):
    numbers = data.draw(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=len(names)))[: len(names)]
    marks = data.draw(st.lists(words.map(lambda word: f"{word}!"), min_size=len(names)))[: len(names)]
    path = tmp_path_factory.mktemp("table") / "labels.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["mark", "name", "number"])
        writer.writerows(zip(marks, names, numbers, strict=True))
    labels = read_labels(path, names, parameters=["number"])
    np.testing.assert_array_equal(labels.parameters[:, 0], numbers)
    assert list(labels.groups["mark"]) == marks


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"expected a column 'name', got an empty file"),
        ("shape,age\na,1\n", r"expected a column 'name', got shape, age"),
        ("name,age,age\na,1,1\n", r"expected each column to have a name of its own, got 'age'"),
        ("name,\na,1\n", r"expected each column to have a name of its own, got ''"),
        ("name,age\na,1\nb,2,3\n", r"line 3: expected 2 columns, got 3"),
        ("name,age\na,1\nb\n", r"line 3: expected 2 columns, got 1"),
        ("name,age\na,1\nb,2\n", r"expected a row for every shape, got none for 'c'"),
        ("name,age\na,1\n", r"expected a row for every shape, got none for 'b' and 1 more"),
        ("name,age\na,1\na,2\n", r"line 3: expected one row a shape, got a second one for 'a'"),
        ("name,age\n../../a,1\n", r"line 2: expected the name of a shape \(a, b, c\), got '../../a'"),
        ("name,age\na,\n", r"line 2: expected a value in column 'age', got an empty cell"),
        ("name,age\na,1\nb,n/a\nc,2\n", r"expected a number in column 'age' for 'b'.*got 'n/a'"),
        ("name,age\na,1\nb,2\nc,nan\n", r"expected a number in column 'age' for 'c'.*got 'nan'"),
        ('name,age\na,"1\n', r"expected comma-separated text in UTF-8"),
    ],
)
def test_bad_labels(table, text, message):
    with pytest.raises(InputError, match=message):
        read_labels(table(text), NAMES)


def test_another_encoding(table):
    with pytest.raises(InputError, match="expected comma-separated text in UTF-8"):
        read_labels(table("name,Größe\na,1\n", "latin-1"), NAMES)


def test_a_group_that_is_not_there(table):
    with pytest.raises(InputError, match=r"expected a column 'sex' to group by, got age"):
        read_labels(table("name,age\na,1\nb,2\nc,3\n"), NAMES, groups=["sex"])


def test_landmarks_by_vertex_point_or_both(table):
    text = "name,landmark,x,y,z,vertex\nc,nose,1,2,3,\nc,left ear,1,2,3,7\na,nose,,,,0\n"
    a, b, c = read_landmarks(table(text), NAMES).rows
    assert [(mark.name, mark.vertex, mark.point) for mark in a] == [("nose", 0, None)]
    assert b == []
    assert [(m.name, m.vertex, m.point) for m in c] == [("nose", None, (1, 2, 3)), ("left ear", 7, (1, 2, 3))]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,landmark\na,nose\n", r"expected a column vertex or columns x, y, z, got name, landmark"),
        ("name,vertex\na,1\n", r"expected a column 'landmark', got name, vertex"),
        ("name,landmark,vertex,colour\na,nose,1,red\n", r"expected columns name, landmark, .*, got 'colour'"),
        ("name,landmark,vertex\nd,nose,1\n", r"line 2: expected the name of a shape .*got 'd'"),
        ("name,landmark,vertex\na,,1\n", r"line 2: expected the landmark's name, got an empty cell"),
        ("name,landmark,vertex\na,nose,1\na,nose,2\n", r"line 3: expected each landmark once, got 'nose' of 'a' again"),
        ("name,landmark,vertex\na,nose,-2\n", r"line 2: expected a vertex, 0 or more, .* got '-2'"),
        ("name,landmark,vertex\na,nose,1.5\n", r"line 2: expected a vertex, 0 or more, .* got '1.5'"),
        ("name,landmark,x,y,z\na,nose,1,2,nan\n", r"line 2: expected a point x, y, z in numbers, got '1', '2'"),
    ],
)
def test_bad_landmarks(table, text, message):
    with pytest.raises(InputError, match=message):
        read_landmarks(table(text), NAMES)
