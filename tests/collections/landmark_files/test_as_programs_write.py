"""Files laid out as the programs write them, and as people then change them: read right, or refused in one line."""

import json

import numpy as np
import pytest

from lssd_learn.collections.landmark_files.files import read_specimens
from lssd_learn.collections.landmark_files.morphoj import is_morphoj
from lssd_learn.errors import InputError

NAN = [np.nan] * 3
SCHEMA = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"


@pytest.fixture
def read(tmp_path):
    """A function: name, text or bytes → the specimens."""

    def write(name, text):
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_specimens(tmp_path / name)

    return write


def control(label, position, status="defined", **others):
    return {
        "id": "vtkMRMLMarkupsFiducialNode_1", "label": label, "description": "",
        "associatedNodeID": "vtkMRMLVectorVolumeNode12\r", "position": position,
        "orientation": [-1.0, -0.0, -0.0, -0.0, -1.0, -0.0, 0.0, 0.0, 1.0],
        "selected": True, "locked": True, "visibility": True, "positionStatus": status,
    } | others  # fmt: skip


def markups(*points, space="LPS", kind="Fiducial", **others):
    one = {
        "type": kind, "coordinateSystem": space, "coordinateUnits": "mm", "locked": False,
        "fixedNumberOfControlPoints": False, "labelFormat": "%N-%d", "lastUsedControlPointNumber": len(points),
        "controlPoints": points, "measurements": [], "display": {"visibility": True, "color": [0.4, 1.0, 1.0]},
    } | others  # fmt: skip
    return {"@schema": f"{SCHEMA}markups-schema-v1.0.3.json#", "markups": [one]}


def test_slicer_markups(read):
    points = [
        control("tip", [-9.33626, -23.9831, 9.71319]),
        control("hidden", [1, 2, 3], visibility=False, selected=False, locked=True),
        control("undefined", "", "undefined"),
        control("missing", [0.0, 0.0, 0.0], "missing"),
        {"label": "bare", "position": [4, 5, 6]},
        control("", [7, 8, 9]),
    ]
    (one,) = read("A_J.mrk.json", json.dumps(markups(*points), indent=4).replace("\n", "\r\n"))
    assert (one.name, one.space, one.notes) == ("A_J", "LPS", ())
    assert one.labels == ("tip", "hidden", "undefined", "missing", "bare", "6")
    known = [[-9.33626, -23.9831, 9.71319], [1, 2, 3], NAN, NAN, [4, 5, 6], [7, 8, 9]]
    np.testing.assert_array_equal(one.points, known)


@pytest.mark.parametrize(("word", "space"), [("LPS", "LPS"), ("RAS", "RAS"), ("0", "RAS"), ("1", "LPS"), (0, "RAS")])
def test_the_coordinate_system_of_markups(read, word, space):
    assert read("a.mrk.json", json.dumps(markups(space=word)))[0].space == space


def test_other_markups_beside_the_points_are_left_out(read):
    whole = markups(control("tip", [1, 2, 3]))
    whole["markups"] += markups(control("c", [1, 1, 1]), kind="ClosedCurve")["markups"]
    (one,) = read("a.mrk.json", json.dumps(whole))
    assert (one.labels, one.notes) == (("tip",), ("left out ClosedCurve",))


@pytest.mark.parametrize(
    ("whole", "message"),
    [
        (markups(space="IJK"), "expected coordinateSystem LPS or RAS, got 'IJK'"),
        (markups(kind="Plane"), "expected one list of points, got 0 beside Plane"),
        ({"markups": markups()["markups"] * 2}, "expected one list of points, got 2"),
        ({"points": []}, "expected the markups of 3D Slicer, got other JSON"),
        ([], "expected the markups of 3D Slicer, got other JSON"),
        (markups(control("tip", ["1,5", "2", "3"])), "'tip': expected a position of three numbers, got .*1,5"),
        (markups(control("tip", [1, 2])), "'tip': expected a position of three numbers, got"),
        (markups(control("tip", [1, 2, float("inf")])), "'tip': expected finite numbers"),
        (markups(control("tip", [1, 2, 3], "sure")), "'tip': expected positionStatus defined, .*, got 'sure'"),
        (markups(control("a\nb", [1, 2, 3])), "expected a name for every landmark, on one line, got .a.nb"),
        (markups(control("tip", [1, 2, 3]), control("tip", [1, 2, 3])), "expected each landmark once, got 'tip' again"),
    ],
)
def test_markups_that_are_refused(read, whole, message):
    with pytest.raises(InputError, match=rf"a.mrk.json: (landmark )?{message}"):
        read("a.mrk.json", json.dumps(whole))


COLUMNS = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"


def test_slicer_fcsv(read):
    text = (
        "# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n" + COLUMNS
        + "vtkMRMLMarkupsFiducialNode_0,-15.4762,-14.8035,16.5802,0,0,0,1,1,1,1,Skull-1,,\n"
        + "vtkMRMLMarkupsFiducialNode_1,-2.145,13.718,-52.409,0.000,0.000,0.000,1.000,0,0,1,Skull-2,,vtkMRMLNode1\n"
        + '2,1,2,3,0,0,0,1,1,1,0,"tip, ""left""","a comment, of two parts",\n\n'
        + "3,nan,nan,nan,0,0,0,1,1,1,0,gone,,\n"
    )  # fmt: skip
    for written in (text, text.replace("\n", "\r\n"), "\ufeff" + text):
        (one,) = read("CAST_EIJ.fcsv", written)
        assert (one.name, one.space, one.notes) == ("CAST_EIJ", "RAS", ())
        assert one.labels == ("Skull-1", "Skull-2", 'tip, "left"', "gone")
        known = [[-15.4762, -14.8035, 16.5802], [-2.145, 13.718, -52.409], [1, 2, 3], NAN]
        np.testing.assert_array_equal(one.points, known)


def test_fcsv_of_slicer_5_says_which_places_are_defined(read):
    head = "# Markups fiducial file version = 5.2\n# CoordinateSystem = LPS\n" + COLUMNS
    (one,) = read("a.fcsv", head + "1,4,5,6,0,0,0,1,1,1,0,F-1,,,2,0\n2,0,0,0,0,0,0,1,1,1,0,F-2,,,0,0\n")
    assert one.space == "LPS"
    np.testing.assert_array_equal(one.points, [[4, 5, 6], NAN])


@pytest.mark.parametrize(("word", "space"), [("0", "RAS"), ("1", "LPS"), ("RAS", "RAS"), ("LPS", "LPS"), ("", "")])
def test_the_coordinate_system_of_fcsv(read, word, space):
    (one,) = read("a.fcsv", (f"# CoordinateSystem = {word}\n" if word else "") + COLUMNS)
    assert one.space == (space or "RAS")
    assert len(one.notes) == (word == "")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# CoordinateSystem = 2\n", r"expected CoordinateSystem RAS \(0\) or LPS \(1\), got '2'"),
        ("1,1,2\n", "line 1: expected 14 columns, got 3"),
        ("1,1,2,x,0,0,0,1,1,1,0,F-1,,\n", "line 1: expected x, y, z, got '1 2 x'"),
        ("1,1,2,,0,0,0,1,1,1,0,F-1,,\n", "line 1: expected x, y, z, got '1 2 '"),
        ('1,"1,5","2,5","3,5",0,0,0,1,1,1,0,F-1,,\n', "line 1: expected decimal points, got commas"),
        ("1,1,5,2,5,3,5,0,0,0,1,1,1,0,F-1,,\n" * 2, "expected each landmark once, got '1' again"),
        ("# columns = label,x,y\n", "expected columns x, y, z, label, got 'label,x,y'"),
    ],
)
def test_fcsv_that_is_refused(read, text, message):
    with pytest.raises(InputError, match=f"a.fcsv: {message}"):
        read("a.fcsv", text)


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
