import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.collections.reading import numbers
from lssd_learn.collections.reading.numbers import Mixed, each_number, is_number, number, read_numbers

FORMS = [
    *("1", "-2.5", "+3", ".5", "4.", "1e3", "2,5", "-0,25", "1,234", "12,345,678", "1.234,5", "1 234.5", "1'234", "−7"),
    *("1_0", "nan", "inf", "E5", "e5", ".", "", "x", "0x1", "1e999", "12a3"),
]
cells = st.builds("".join, st.tuples(st.sampled_from(FORMS), st.sampled_from(["", " ", ""]), st.just("")))
columns = st.one_of(
    st.lists(cells, min_size=1, max_size=4),
    st.tuples(st.lists(cells, min_size=1, max_size=4), st.sampled_from(["mm", " kg", "m²", " m2", "x", "'"])).map(
        lambda both: [text + both[1] for text in both[0]]
    ),
)


def outcome(texts, separator):
    try:
        found = read_numbers(texts, separator)
    except Mixed as error:
        return str(error)
    return found and (found.values.tolist(), found.unit, found.comma)


@given(columns, st.sampled_from(",;\t"))
def test_a_column_read_at_once_is_that_read_cell_by_cell(texts, separator):
    texts = [text.strip() for text in texts]
    found = outcome(texts, separator)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(numbers, "_usual", lambda texts: None)
        assert outcome(texts, separator) == found


@given(st.lists(cells.map(str.strip), max_size=4))
def test_each_cell_of_a_column_is_read_on_its_own(texts):
    def alone(text):
        found = outcome([text], ",")
        return None if isinstance(found, str) or found is None or found[1] else found[0][0]

    assert each_number(texts) == [number(text) for text in texts] == [alone(text) for text in texts]
    for text in texts:
        found = outcome([text], ";")
        assert is_number(text) == (found is not None and not found[1])


@pytest.mark.parametrize("texts", [["E5", "E6"], [".e5", "1"], [",", ";"], ["e1 mm"]])
def test_what_has_no_digit_before_its_exponent_is_no_number(texts):
    assert read_numbers(texts) is None


def test_a_unit_behind_all_cells():
    found = read_numbers(["1,5 cm", "2cm", "-3,25  cm"])
    np.testing.assert_array_equal(found.values, [1.5, 2, -3.25])
    assert (found.unit, found.comma) == ("cm", True)
