"""What is written is read back: names, places to the last digit, missing landmarks, the coordinate system."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lssd_learn.collections.landmark_files.files import FORMATS, ONE_SPECIMEN, read_specimens, write_specimens
from lssd_learn.collections.landmark_files.specimen import Specimen, numbered
from lssd_learn.errors import InputError

WITH_LABELS = ("mrk.json", "fcsv", "pts", "morphoj")  # the others know landmarks by their order
WITH_SPACE = ("mrk.json", "fcsv")
WORDS = st.text("aLöé09 .-", min_size=1, max_size=6).map(lambda word: f"p{word.strip()}")
PLACES = st.floats(-1e5, 1e5, allow_subnormal=False).filter(lambda x: x not in (-1, 9999))


@st.composite
def sets(draw) -> list[Specimen]:
    labels = tuple(draw(st.lists(WORDS, min_size=1, max_size=4, unique=True)))
    names = draw(
        st.lists(st.text("ab _-0", min_size=1, max_size=5).map("s{}e".format), min_size=1, max_size=3, unique=True)
    )
    found = []
    for name in names:
        points = draw(arrays(np.float64, (len(labels), 3), elements=PLACES))
        points[draw(arrays(bool, len(labels)))] = np.nan
        found.append(Specimen(name, labels, points, draw(st.sampled_from(["LPS", "RAS"]))))
    return found


@pytest.mark.parametrize("form", FORMATS)
@settings(max_examples=25, deadline=None)
@given(specimens=sets())
def test_what_is_written_is_read_back(tmp_path_factory, form, specimens):
    folder = tmp_path_factory.mktemp("written")
    files = write_specimens(specimens, folder, form)
    found = [one for file in files for one in read_specimens(file)]
    assert [one.name for one in found] == [one.name for one in specimens]
    for one, known in zip(found, specimens, strict=True):
        np.testing.assert_array_equal(one.points, known.points)
        assert one.labels == (known.labels if form in WITH_LABELS else tuple(numbered(len(known.labels))))
        assert one.space == (known.space if form in WITH_SPACE else "")
        assert one.notes == ()


def test_a_turn_to_the_other_system_and_back_changes_nothing():
    one = Specimen("a", ("tip", "side"), np.array([[1.0, 2, 3], [np.nan] * 3]), "LPS")
    np.testing.assert_array_equal(one.in_space("RAS").points[0], [-1, -2, 3])
    np.testing.assert_array_equal(one.in_space("RAS").in_space("LPS").points, one.points)
    assert one.in_space("") is one
    assert one.missing == ["side"]


def test_a_file_name_is_made_of_any_name(tmp_path):
    one = Specimen("../a/b", ("tip",), np.zeros((1, 3)))
    assert write_specimens([one], tmp_path, "pts") == [tmp_path / ".._a_b.pts"]


def test_what_cannot_be_written_is_refused(tmp_path):
    one, two = Specimen("a", ("tip",), np.zeros((1, 3))), Specimen("b", ("tip", "side"), np.zeros((2, 3)))
    with pytest.raises(InputError, match=r"expected a format of landmarks, one of mrk\.json, .*, got 'land'"):
        write_specimens([one], tmp_path, "land")
    with pytest.raises(InputError, match="expected landmarks to write"):
        write_specimens([], tmp_path, "pts")
    with pytest.raises(InputError, match="expected a folder, it is not there"):
        write_specimens([one], tmp_path / "no", "pts")
    with pytest.raises(InputError, match=r"landmarks.txt: expected the same number of landmarks .* got \[1, 2\]"):
        write_specimens([one, two], tmp_path, "morphologika")
    with pytest.raises(InputError, match=r"landmarks.txt: expected the same landmarks of all"):
        write_specimens([one, two], tmp_path, "morphoj")
    assert list(tmp_path.iterdir()) == []


def test_one_format_is_one_file_or_one_a_specimen():
    assert {form for form in FORMATS if f".{form}" in ONE_SPECIMEN} == {"mrk.json", "fcsv", "pts"}
