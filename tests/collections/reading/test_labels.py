import csv
import logging

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import read_landmarks
from lssd_learn.collections.reading.names import Names, composed
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


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("name;age\na;1,5\nb;2\nc;-3,25\n", [1.5, 2, -3.25]),
        ("name\tage\na\t1,5\nb\t2\nc\t0,125\n", [1.5, 2, 0.125]),
        ('name,age\na,"1,5"\nb,2\nc,"3,25"\n', [1.5, 2, 3.25]),
        ("name,age\na,12 mm\nb,1.5mm\nc, 3 mm\n", [12, 1.5, 3]),
        ("name;age\na;12,5 mm\nb;1,5 mm\nc;3 mm\n", [12.5, 1.5, 3]),
        ("sep=;\nName;age\na;1\nb;2\nc;4\n", [1, 2, 4]),
        ("name;age\na;1.234,5\nb;2\nc;1 000,5\n", [1234.5, 2, 1000.5]),
        ('name,age\na,"1,234.5"\nb,2\nc,"1,234,567"\n', [1234.5, 2, 1234567]),
        ("name,age\na,−1\nb,2\nc,+3e1\n", [-1, 2, 30]),
        ("name,age\na,5 %\nb,10%\nc,20 %\n", [5, 10, 20]),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_numbers_as_people_write_them(table, text, values, encoding):
    labels = read_labels(table(text, encoding), NAMES)
    assert labels.parameter_names == ["age"]
    np.testing.assert_allclose(labels.parameters[:, 0], values)


def test_a_unit_or_a_decimal_comma_is_told(table, caplog):
    caplog.set_level(logging.INFO)
    read_labels(table("name;age\na;12,5 mm\nb;1 mm\nc;3 mm\n"), NAMES)
    assert "column 'age' is read as numbers in 'mm' with a decimal comma: '12,5 mm' is 12.5" in caplog.text


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (["12 mm", "1 cm", "2 mm"], "expected one unit in all cells or none, got '12 mm' and '1 cm'"),
        (["12 mm", "13", "2 mm"], "expected one unit in all cells or none, got '12 mm' and '13'"),
        (["0.5", '"1,5"', "2"], "expected one decimal sign, got '0.5' and '1,5'"),
        (['"1,234"', '"2,345"', "2"], "expected a point as the decimal sign: '1,234' can be read in two ways"),
    ],
)
def test_numbers_that_can_be_read_in_two_ways_are_refused(table, cells, message):
    text = "name,age\n" + "".join(f"{name},{cell}\n" for name, cell in zip(NAMES, cells, strict=True))
    with pytest.raises(InputError, match=f"column 'age': {message}"):
        read_labels(table(text), NAMES)
    assert list(read_labels(table(text), NAMES, groups=["age"]).groups) == ["age"]


def test_points_in_one_column_and_commas_in_another_are_refused(table):
    with pytest.raises(InputError, match="expected one decimal sign, column 'mass' has points and column 'age' commas"):
        read_labels(table("name;age;mass\na;1,5;1.234\nb;2;1.3\nc;3;1.5\n"), NAMES)


@pytest.mark.parametrize(
    "cells", ["3a 3b 4a", "1st 2nd 3rd", "2020-01-05 2020-01-06 2021-01-05", "1/2 1/3 1/4", "M1 M2 M3"]
)
def test_codes_stay_groups(table, cells):
    cells = cells.split()
    text = "name,code\n" + "".join(f"{name},{cell}\n" for name, cell in zip(NAMES, cells, strict=True))
    assert list(read_labels(table(text), NAMES).groups["code"]) == cells


@pytest.mark.parametrize(
    ("column", "cells"),
    [
        ("id", [7, 3, 9]), ("ID", [1.5, 2, 3]), ("specimen_id", [7, 3, 9]), ("SpecimenID", [7, 3, 9]),
        ("nr", [3, 1, 2]), ("Index", [0, 1, 2]), ("catalogue number", [7, 3, 9]), ("height", [2, 2, 2]),
    ],
)  # fmt: skip
def test_what_numbers_the_shapes_or_is_constant_is_no_target_unless_asked_for(table, caplog, column, cells):
    caplog.set_level(logging.INFO)
    path = table(
        f"name,{column},age\n" + "".join(f"{n},{c},{ord(n) ** 2}\n" for n, c in zip(NAMES, cells, strict=True))
    )
    assert read_labels(path, NAMES).parameter_names == ["age"]
    labels = read_labels(path, NAMES, groups=["age"])
    assert labels.parameters is None
    assert f"no targets unless collection.parameters=[…] names them: {column} (" in caplog.text
    assert f"{column} (" in labels.lacks("parameters")
    asked = read_labels(path, NAMES, groups=["age"], parameters=[column])
    np.testing.assert_array_equal(asked.parameters[:, 0], cells)


@pytest.mark.parametrize("column", ["index", "number of teeth", "width", "android", "idle"])
def test_a_measurement_is_a_target_whatever_its_name(table, column):
    assert read_labels(table(f"name,{column}\na,1.5\nb,3.5\nc,2\n"), NAMES).parameter_names == [column]


def test_targets_can_be_chosen(table):
    text = "name,age,mass,sex\na,1,5,m\nb,3,6,f\nc,2,8,m\n"
    labels = read_labels(table(text), NAMES, parameters=["mass"])
    assert labels.parameter_names == ["mass"]
    assert list(labels.groups) == ["sex"]
    for wanted, groups, message in (
        (["size"], [], "expected a column 'size' of collection.parameters, got age, mass, sex"),
        (["sex"], [], "expected numbers in column 'sex' of collection.parameters, got 'm'"),
        (["age"], ["age"], "expected 'age' in one of them, got both"),
    ):
        with pytest.raises(InputError, match=message):
            read_labels(table(text), NAMES, groups, wanted)


def test_a_column_of_the_other_kind_says_how_to_change_it(table):
    numbers = read_labels(table("name,sex\na,0\nb,1\nc,0\n"), NAMES)
    assert numbers.lacks("groups") == "sex is taken as numbers, and collection.groups=[sex] makes a group of sex"
    words = read_labels(table("name,age\na,0\nb,old\nc,0\n"), NAMES)
    assert words.lacks("parameters").startswith("the columns of labels.csv are groups: age (such as '0')")


def test_what_may_be_no_target_is_a_warning(table, caplog):
    read_labels(table("name,age,mass\na,1,5\nb,2,-9999\nc,3,6\n"), NAMES)
    assert len(caplog.messages) == 2
    assert "column 'age' counts the shapes" in caplog.messages[0]
    assert "column 'mass' is -9999 for 'b': a number, though it looks like a code" in caplog.messages[1]


def test_names_in_one_piece_or_two_with_their_accents(table):
    composed_, in_pieces = "Sch\u00e4del", "Scha\u0308del"
    for name in (composed_, in_pieces, f"{in_pieces}.off"):
        labels = read_labels(table(f"name,g\n{name},x\nb,y\n"), Names([composed_, "b"], [f"{in_pieces}.off", "b.off"]))
        assert list(labels.groups["g"]) == ["x", "y"]
    labels = read_labels(table(f"name,{in_pieces}\na,{in_pieces}\nb,{composed_}\nc,x\n"), NAMES)
    assert list(labels.groups[composed_]) == [composed_, composed_, "x"]


def test_a_name_written_otherwise_is_pointed_at(table):
    with pytest.raises(InputError, match=r"line 2: expected the name of a shape \(S_1\), got 's1'; 'S_1' is written"):
        read_labels(table("name,g\ns1,x\n"), ["S_1"])


def test_a_group_that_is_not_there(table):
    with pytest.raises(InputError, match=r"expected a column 'sex' to group by, got age"):
        read_labels(table("name,age\na,1\nb,2\nc,3\n"), NAMES, groups=["sex"])


def test_landmarks_by_vertex_point_or_both(table):
    text = "name,landmark,x,y,z,vertex\nc,nose,1,2,3,\nc,left ear,1,2,3,7\na,nose,,,,0\n"
    a, b, c = read_landmarks(table(text), NAMES).rows
    assert [(mark.name, mark.vertex, mark.point) for mark in a] == [("nose", 0, None)]
    assert b == []
    assert [(m.name, m.vertex, m.point) for m in c] == [("nose", None, (1, 2, 3)), ("left ear", 7, (1, 2, 3))]


@pytest.mark.parametrize("code", ["-1", "-9999", "", "NA", "nan", "-1.0"])
def test_landmarks_that_are_missing(table, code):
    read = read_landmarks(table(f"name,landmark,vertex\na,nose,{code}\na,ear,3\nb,nose,1\n"), NAMES)
    assert [[mark.name for mark in marks] for marks in read.rows] == [["ear"], ["nose"], []]
    assert read.missing == [["nose"], [], []]
    if not code.startswith("-"):
        read = read_landmarks(table(f"name,landmark,x,y,z\na,nose,{code},{code},{code}\n"), NAMES)
        assert read.missing == [["nose"], [], []]
    elif code != "-1.0":
        (landmark,) = read_landmarks(table(f"name,landmark,x,y,z\na,nose,{code},{code},{code}\n"), NAMES).rows[0]
        assert landmark.doubtful  # it may be a place


def test_landmarks_with_semicolons_and_commas(table):
    (a,), *_ = read_landmarks(table("Name;Landmark;X;Y;Z\na;nose;1,5;2;-0,25\n"), NAMES).rows
    assert a.point == (1.5, 2, -0.25)


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
