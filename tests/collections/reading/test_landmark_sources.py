"""Landmarks of a folder in the forms of other programs: found, told by the same names, in the mesh's coordinates."""

import logging

import numpy as np
import pytest

from lssd_learn.collections import Aligned, Folder
from lssd_learn.collections.landmark_files.files import FORMATS, write_specimens
from lssd_learn.collections.landmark_files.specimen import Specimen
from lssd_learn.errors import InputError
from lssd_learn.shapes import load, save

MARKS = [5, 17, 40, 61, 88, 100, 131, 150]
LABELS = tuple(f"F-{k + 1}" for k in range(8))


@pytest.fixture
def specimens(lumps):
    return [Specimen(f"s{i}", LABELS, mesh.vertices[MARKS], "LPS") for i, mesh in enumerate(lumps(5))]


def says(folder, space):
    """Have the meshes, as PLY, say their coordinate system as 3D Slicer does."""
    for file in folder.glob("*.off"):
        save(load(file), file.with_suffix(".ply"))
        file.unlink()
        ply = file.with_suffix(".ply")
        ply.write_bytes(ply.read_bytes().replace(b"1.0\n", b"1.0\ncomment SPACE=" + space.encode() + b"\n", 1))


@pytest.mark.parametrize("form", FORMATS)
def test_each_form_is_read_as_a_table_of_our_own(folder, specimens, form):
    points = specimens[1].points.copy()
    points[2] = np.nan
    write_specimens([specimens[0], Specimen("s1", LABELS, points, "LPS"), *specimens[3:]], folder, form)
    shapes = Folder(folder)
    warnings = shapes.check()
    assert warnings == []
    labels = LABELS if form in ("mrk.json", "fcsv", "pts", "morphoj") else tuple("12345678")
    assert shapes.landmarks[0] == dict(zip(labels, MARKS, strict=True))
    assert shapes.landmarks[1] == {label: v for label, v in shapes.landmarks[0].items() if label != labels[2]}
    assert shapes.landmarks.place(1).missing == [labels[2]]
    np.testing.assert_array_equal(shapes.landmarks.place(3).places[labels[4]], specimens[3].points[4])
    assert shapes.landmarks[2] == {}  # the shape that no file tells of
    assert shapes.space(0) == shapes.space(2) == ("LPS" if form in ("mrk.json", "fcsv") else "")


def test_a_file_that_changes_changes_the_key(folder, specimens):
    write_specimens(specimens, folder, "pts")
    before = Folder(folder).key
    write_specimens([Specimen("s3", LABELS, specimens[3].points + 1e-3)], folder, "pts")
    assert Folder(folder).key != before


@pytest.mark.parametrize(("said", "meshes"), [("LPS", "RAS"), ("RAS", "LPS"), ("LPS", "LPS")])
def test_points_are_taken_to_the_system_of_the_mesh(folder, specimens, caplog, said, meshes):
    says(folder, meshes)
    here = [Specimen(one.name, one.labels, one.points, meshes).in_space(said) for one in specimens]
    write_specimens(here, folder, "fcsv")
    shapes = Folder(folder)
    with caplog.at_level(logging.INFO):
        assert shapes.check() == []
    assert shapes.landmarks[2] == dict(zip(LABELS, MARKS, strict=True))
    assert shapes.space(2) == shapes[1:].space(1) == meshes
    line = f"*.fcsv: landmarks in {said} are taken to {meshes}, the coordinate system of their shapes"
    assert caplog.messages.count(line) == (said != meshes)


def test_of_meshes_that_say_none_the_fit_decides(folder, specimens):
    write_specimens([one.in_space("RAS") for one in specimens], folder, "mrk.json")
    shapes = Folder(folder)
    (warning,) = shapes.check()
    assert shapes.space(0) == "LPS"
    assert warning.startswith(
        "*.mrk.json: landmarks in RAS are off the surface as they stand and on it in LPS: that is"
    )
    assert shapes.landmarks[2] == dict(zip(LABELS, MARKS, strict=True))


def test_a_shape_that_is_turned_is_in_no_system(folder):
    says(folder, "RAS")
    assert Aligned(Folder(folder), align="none").space(0) == "RAS"
    assert Aligned(Folder(folder), cache=None).space(0) == ""


def test_a_wrong_word_on_the_system_is_refused(folder, specimens):
    says(folder, "LPS")
    write_specimens([Specimen(one.name, one.labels, one.points, "RAS") for one in specimens], folder, "fcsv")
    with pytest.raises(
        InputError, match=r"\*.fcsv: expected landmarks on s0.ply: .* with x and y negated \(LPS for RAS"
    ):
        Folder(folder).check()


def test_the_name_that_slicer_puts_before_each_number_is_no_difference(folder, specimens):
    for one in specimens:
        labels = tuple(f"{one.name}_skull-{k + 1}" for k in range(8))
        write_specimens([Specimen(one.name, labels, one.points, "LPS")], folder, "fcsv")
    assert Folder(folder).landmarks[1] == {str(k + 1): vertex for k, vertex in enumerate(MARKS)}


def test_other_landmarks_than_others_have_are_told_or_refused(folder, specimens):
    write_specimens(specimens, folder, "fcsv")
    write_specimens([Specimen("s3", LABELS[:6], specimens[3].points[:6], "LPS")], folder, "fcsv")
    shapes = Folder(folder)
    (warning,) = shapes.check()
    assert warning == f"{folder / 's3.fcsv'}: no landmark F-7, F-8, which others have: taken as missing"
    assert shapes.landmarks.place(3).missing == ["F-7", "F-8"]
    write_specimens([Specimen("s3", (*LABELS[:7], "tip"), specimens[3].points, "LPS")], folder, "fcsv")
    with pytest.raises(InputError, match=r"s3.fcsv: expected the 8 landmarks of .*s0.fcsv, got 8, of them 'tip'$"):
        Folder(folder)


def test_by_their_order_alone_landmarks_have_to_be_as_many(folder, specimens):
    write_specimens([*specimens[:4], Specimen("s4", LABELS[:7], specimens[4].points[:7])], folder, "tps")
    with pytest.raises(InputError, match=r"landmarks.tps: s4: expected the 8 landmarks of .*tps: s0, got 7$"):
        Folder(folder)


@pytest.mark.parametrize(("one", "two"), [("fcsv", "pts"), ("tps", "mrk.json"), ("tps", "morphologika")])
def test_two_forms_at_once_are_refused_and_both_named(folder, specimens, one, two):
    files = [write_specimens(specimens, folder, form)[0].name for form in (one, two)]
    with pytest.raises(InputError, match="expected landmarks in one form, got ") as refused:
        Folder(folder)
    assert all(file in str(refused.value) for file in files)


def test_a_table_of_our_own_beside_another_form_is_one_too_many(folder, specimens):
    write_specimens(specimens, folder, "fcsv")
    (folder / "landmarks.csv").write_text("name,landmark,x,y,z\n")
    with pytest.raises(InputError, match=r"expected landmarks in one form, got landmarks.csv and s0.fcsv"):
        Folder(folder)


def test_landmarks_of_no_shape_are_told_and_left_alone(folder, specimens):
    write_specimens([*specimens[:2], Specimen("atlas", LABELS, specimens[0].points, "LPS")], folder, "fcsv")
    (warning,) = Folder(folder).check()
    assert warning == f"{folder.name}: not read: atlas.fcsv: landmarks, but not called after a shape, such as s0.fcsv"
    write_specimens([*specimens[:2], Specimen("s7", LABELS, specimens[0].points)], folder, "tps")
    for file in folder.glob("*.fcsv"):
        file.unlink()
    with pytest.raises(InputError, match=r"landmarks.tps: expected the name of a shape \(s0, s1, s2, …\), got 's7'"):
        Folder(folder)


def test_the_wide_table_of_morphoj_may_be_called_as_ours(folder, specimens):
    write_specimens(specimens, folder, "morphoj")
    (folder / "landmarks.txt").rename(folder / "landmarks.csv")
    assert Folder(folder).landmarks[4] == dict(zip(LABELS, MARKS, strict=True))


def test_several_specimens_in_the_file_of_one_are_refused(folder, specimens):
    write_specimens(specimens[:2], folder, "tps", name="s1")
    with pytest.raises(InputError, match=r"s1.tps: expected the landmarks of the shape of this name alone, got 2"):
        Folder(folder)


def test_a_text_that_is_no_landmarks_is_left_alone(folder):
    (folder / "notes.txt").write_text("what was done when\n")
    (folder / "landmarks.txt").write_text("placed by A. on Monday\n")
    shapes = Folder(folder)
    assert len(shapes.landmarks) == 0
    assert shapes.check() == [
        f"{folder.name}: not read: landmarks.txt (tables are labels.csv and landmarks.csv, or .tsv)"
    ]
