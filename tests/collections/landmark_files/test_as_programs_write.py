"""Files laid out as the programs write them, and as people then change them: read right, or refused in one line."""

import numpy as np
import pytest

from lssd_learn.collections.landmark_files.morphoj import is_morphoj
from lssd_learn.errors import InputError

NAN = [np.nan] * 3
TPS = "LM3=2\n1.5 2.5 3.5\n-4 5 -6\nIMAGE=C:\\bones\\A J.ply\nID=0\n"


def test_tps(read):
    other = (
        "lm3=2\n-1 -1 -1\nNA NA NA\nCURVES=1\nPOINTS=2\n1 2 3\n4 5 6\nIMAGE=B.jpg\nID=1\nCOMMENT=the left = broken\n"
    )
    for text in (TPS + other, (TPS + other).replace("\n", "\r\n"), "\ufeff" + TPS + "\n" + other):
        first, second = read("bones.tps", text)
        assert (first.name, second.name, first.labels) == ("A J", "B", ("1", "2"))
        np.testing.assert_array_equal(first.points, [[1.5, 2.5, 3.5], [-4, 5, -6]])
        np.testing.assert_array_equal(second.points, [NAN, NAN])
        assert first.notes == ("left out 1 curve",)


def test_tps_of_geomorph_has_names_for_numbers_and_a_scale(read):
    one, two = read("a.TPS", "LM=1\n1 2 3\nID=A_J\nSCALE=0.5\n\nLM=1\n2 4 6\nID=B_J\nSCALE=2\n")
    assert (one.name, two.name) == ("A_J", "B_J")
    np.testing.assert_array_equal([one.points[0], two.points[0]], [[0.5, 1, 1.5], [4, 8, 12]])


def test_decimal_commas_are_taken_for_points_where_nothing_else_has_them(read):
    (one,) = read("a.tps", "LM3=1\n1,5 -2,25 3\nID=a\n")
    np.testing.assert_array_equal(one.points, [[1.5, -2.25, 3]])
    assert one.notes == ("decimal commas taken for points",)
    with pytest.raises(InputError, match="a.tps: line 3: expected x, y, z, got '1,5 2 3': numbers with decimal commas"):
        read("a.tps", "LM3=2\n1.5 2.5 3.5\n1,5 2 3\nID=a\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("LM=1\n1 2\nID=a\n", "line 2: expected landmarks in three dimensions, got '1 2'"),
        ("LM3=2\n1 2 3\nID=a\n", "specimen 1 announces 2 landmarks, 1 are there"),
        ("LM3=1\n1 2 3\n4 5 6\nID=a\n", "specimen 1 announces 1 landmarks, 2 are there"),
        (TPS + "SCALE=2\n" + TPS.replace("A J", "B"), "expected SCALE= of all 2 specimens or of none, got it of 1"),
        (TPS + "SCALE=0\n", "expected SCALE= above 0, got '0'"),
        (TPS + TPS, "expected each specimen once, got 'A J' again"),
        ("1 2 3\n", "line 1: expected LM3= before anything else, got '1 2 3'"),
        ("LM3=x\n", "line 1: expected a whole number, got 'x'"),
        ("LM3=1\n1 2 x\nID=a\n", "line 2: expected x, y, z, got '1 2 x'"),
    ],
)
def test_tps_that_is_refused(read, text, message):
    with pytest.raises(InputError, match=f"a.tps: {message}"):
        read("a.tps", text)


MORPHOLOGIKA = (
    "[Individuals]\n2\n[landmarks]\n2\n[Dimensions]\n3\n[names]\nA J\nB_J\n[labels]\nsex\n[labelvalues]\nm\nf\n"
    "[rawpoints]\n\n'#1\n\n1 2 3\n4\t5\t6.5\n\n'#2\n\n-1 -2 -3\nNaN NaN NaN\n[wireframe]\n1 2\n"
)


def test_morphologika(read):
    for text in (MORPHOLOGIKA, MORPHOLOGIKA.replace("\n", "\r\n"), "\ufeff" + MORPHOLOGIKA):
        first, second = read("bones.txt", text)
        assert (first.name, second.name, first.labels) == ("A J", "B_J", ("1", "2"))
        np.testing.assert_array_equal(first.points, [[1, 2, 3], [4, 5, 6.5]])
        np.testing.assert_array_equal(second.points, [[-1, -2, -3], NAN])


def test_the_number_that_landmark_editor_writes_for_missing_is_told_in_morphologika(read):
    first, second = read("bones.txt", MORPHOLOGIKA.replace("1 2 3", "9999 9999 9999.0").replace("'#1", "' first"))
    np.testing.assert_array_equal(first.points, [NAN, [4, 5, 6.5]])
    assert first.notes == second.notes == ("9999 three times taken for missing",)


def test_morphologika_named_between_its_points_and_of_one_specimen(read):
    text = MORPHOLOGIKA.replace("[names]\nA J\nB_J\n", "").replace("'#1", "'A J").replace("'#2", "'#B_J")
    assert [one.name for one in read("bones.txt", text)] == ["A J", "B_J"]
    text = "[individuals]\n1\n[landmarks]\n1\n[dimensions]\n3\n[rawpoints]\n1 2 3\n"
    assert read("A_J.txt", text)[0].name == "A_J"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[Dimensions]\n3", "[Dimensions]\n2", "expected landmarks in three dimensions, got 2"),
        ("2\n[landmarks]", "3\n[landmarks]", "it announces 3 times 2 landmarks, 4 lines of points are there"),
        ("B_J\n", "", "expected the names of 2 individuals, got 1"),
        ("B_J", "A J", "expected each specimen once, got 'A J' again"),
        ("[labels]", "[lables]", r"line 10: expected a section of Morphologika, got '\[lables\]'"),
        ("[labels]", "[names]", r"line 10: expected each section once, got \[names\] again"),
        ("[landmarks]\n2\n", "", r"expected one number in section \[landmarks\], got 0 lines"),
        ("1 2 3", "1 2", "line 19: expected x, y, z, got '1 2'"),
        ("1 2 3", "1,5 2 3", "line 20: .* numbers with decimal commas beside numbers with points"),
    ],
)
def test_morphologika_that_is_refused(read, old, new, message):
    with pytest.raises(InputError, match=f"a.txt: {message}"):
        read("a.txt", MORPHOLOGIKA.replace(old, new, 1))


@pytest.mark.parametrize("mark", ["\t", ",", ";"])
def test_morphoj(read, mark):
    rows = ["ID x1 y1 z1 x2 y2 z2", "A_J 1 2.5 3 -4 5 6", "B_J 1 2 3 NA NA NA"]
    morpho = ["id.string X1 X2 X3 X4 X5 X6"]
    for header in (rows[:1], [], morpho, ["specimen LM1_X LM1_Y LM1_Z LM2_X LM2_Y LM2_Z"]):
        text = "\n".join(header + rows[1:]).replace(" ", mark) + "\n"
        assert is_morphoj(text)
        for written in (text, text.replace("\n", "\r\n"), "\ufeff" + text):
            first, second = read("a.txt", written)
            assert (first.name, second.name) == ("A_J", "B_J")
            assert first.labels == (("LM1", "LM2") if header and "LM1" in header[0] else ("1", "2"))
            np.testing.assert_array_equal(first.points, [[1, 2.5, 3], [-4, 5, 6]])
            np.testing.assert_array_equal(second.points, [[1, 2, 3], NAN])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "ID\tx1\ty1\tx2\ty2\na\t1\t2\t3\t4\n",
            "expected columns x, y, z of one landmark after the other, got x1, y1, x2",
        ),
        ("ID\tx1\ty1\tz1\na\t1\t2\n", "line 2: expected a name and 1 times x, y, z, got 3 columns"),
        ("ID\tx1\ty1\tz1\n\t1\t2\t3\n", "line 2: expected the name of a specimen, got an empty cell"),
        ("ID\tx1\ty1\tz1\na\t1\t2\t3\na\t1\t2\t3\n", "expected each specimen once, got 'a' again"),
        ("ID\tx1\ty1\tz1\na\t1\t2\tNA\n", "line 2: expected x, y, z, got '1 2 NA'"),
        ("ID;x1;y1;z1\na;1,5;2;3\nb;1.5;2;3\n", "line 3: .* numbers with decimal commas beside numbers with points"),
        ("ID\tx1\ty1\tz1\n", "expected a line a specimen, found none"),
        ("# by A.\nID\tx1\ty1\tz1\na\t1\t2\t3\n", "line 1: expected a name and x, y, z of landmarks, got '# by A.'"),
    ],
)
def test_morphoj_that_is_refused(read, text, message):
    with pytest.raises(InputError, match=f"a.txt: {message}"):
        read("a.txt", text)


def test_landmark_editor(read):
    text = "Version 1.0\n3\nS000 -12.5 3.25 1e1 \nS001 9999.000000 9999.000000 9999.000000\nC000_001  1  2  3\n"
    for written in (text, text.replace("\n", "\r\n"), "\ufeff" + text):
        (one,) = read("A_J.pts", written)
        assert (one.name, one.labels, one.space) == ("A_J", ("S000", "S001", "C000_001"), "")
        np.testing.assert_array_equal(one.points, [[-12.5, 3.25, 10], NAN, [1, 2, 3]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("version: 1\nn_points: 2\n{\n1 2\n}\n", "expected Version 1.0 in its first line"),
        ("Version 1.0\nS0 1 2 3\n", "expected the number of points in its second line"),
        ("1 2 3\n", "expected Version 1.0 in its first line"),
        ("Version 1.0\n2\nS0 1 2 3\n", "it announces 2 points, 1 are there"),
        ("Version 1.0\n1\n1 2 3\n", "line 3: expected a name and x, y, z, got '1 2 3'"),
        (
            "Version 1.0\n2\nS0 1.5 2 3\nS1 1,5 2 3\n",
            "line 4: .* numbers with decimal commas beside numbers with points",
        ),
        ("Version 1.0\n2\nS0 1 2 3\nS0 1 2 3\n", "expected each landmark once, got 'S0' again"),
    ],
)
def test_landmark_editor_that_is_refused(read, text, message):
    with pytest.raises(InputError, match=f"a.pts: {message}"):
        read("a.pts", text)


@pytest.mark.parametrize("name", ["a.mrk.json", "a.fcsv", "a.tps", "a.txt", "a.pts"])
def test_what_is_no_text_is_refused(read, name):
    for data in (b"", b" \n", b"\0\1\2", b"\xff\xfe\0"):
        with pytest.raises(InputError, match=rf"{name}: "):
            read(name, data)


def test_another_suffix_is_refused(read):
    with pytest.raises(InputError, match=r"a.land: expected landmarks \(.mrk.json .*\), got a.land"):
        read("a.land", "x")
