"""Landmarks as 3D Slicer writes them, and as people then change them: read right, or refused in one line."""

import json

import numpy as np
import pytest

from lssd_learn.errors import InputError

NAN = [np.nan] * 3
SCHEMA = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"


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
