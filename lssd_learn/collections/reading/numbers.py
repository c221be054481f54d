"""A column of cells as numbers: decimal commas and points, thousands, units behind. Used by `labels.py`.

What can be read in two ways is refused, never chosen; what is no column of numbers at all is left to be a group.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# How people write that they do not know a number.
MISSING = {"na", "n/a", "n.a.", "nan", "none", "null", "nil", "unknown", "missing", "inf", "-inf", "?", "-", "–", "—"}

# What follows a number and is no unit of one's own making. Of these, a mixture is refused; of others, it is a group.
UNITS = frozenset(
    [
        *("nm", "µm", "um", "mm", "cm", "dm", "m", "km", "in", "inch", "inches", "ft", "feet", "yd", "'", '"'),
        *("mm2", "mm²", "cm2", "cm²", "m2", "m²", "mm3", "mm³", "cm3", "cm³", "m3", "m³", "ml", "cl", "dl", "l"),
        *("µg", "ug", "mg", "g", "kg", "t", "lb", "lbs", "oz", "kg/m2", "kg/m²", "g/cm3", "g/cm³"),
        *("ms", "s", "sec", "min", "h", "hr", "hrs", "d", "day", "days", "wk", "week", "weeks", "month", "months"),
        *("y", "yr", "yrs", "year", "years", "ka", "kya", "ma", "mya", "°", "deg", "rad", "%", "‰", "ppm", "°c", "°f"),
        *("′", "″", "mo", "hz", "khz", "mhz", "pa", "kpa", "mpa", "gpa", "n", "kn", "w", "v"),
    ]
)

GROUPS = "[ '’\u00a0\u2009\u202f]"  # that stand between thousands, whatever the decimal sign
_GROUPS = re.compile(GROUPS)
_SIGN, _EXPONENT = r"[+\-]?", r"(?:[eE][+\-]?\d+)?"
_NUMBER = {
    mark: re.compile(
        rf"{_SIGN}(?={mark}?\d)(?:\d+|[1-9]\d{{0,2}}(?:(?:{other}\d{{3}})+|(?:{GROUPS}\d{{3}})+))?(?:{mark}\d*)?{_EXPONENT}"
    )
    for mark, other in ((r"\.", ","), (",", r"\."))
}
POINT, COMMA = _NUMBER[r"\."], _NUMBER[","]
_THOUSANDS = re.compile(r"[+\-]?[1-9]\d{0,2}(?:,\d{3})+")
# A number and what stands behind it: a unit begins with a letter or a sign of its own and holds no other digits.
_WITH_UNIT = re.compile(
    r"([+\-]?[\d.,][\d.,'’ \u00a0\u2009\u202f]*?(?:[eE][+\-]?\d+)?)\s*((?:[^\W\d_²³]|[%‰°′″'\"])[^\d!?]*[²³23]?)"
)


@dataclass(frozen=True, eq=False)
class Numbers:
    """A column as numbers.

    Attributes:
        values: (n,) float64.
        unit: that stands behind each of them; "" without.
        comma: whether a comma was the decimal sign.
    """

    values: np.ndarray
    unit: str = ""
    comma: bool = False


class Mixed(ValueError):
    """A column of numbers that can be read in more than one way: the message says expected and got."""


def read_numbers(texts: Sequence[str], separator: str = ",") -> Numbers | None:
    """The numbers of a column, or None if it is not one of numbers.

    Args:
        texts: its cells.
        separator: of the table's columns: between semicolons a comma is a decimal sign.

    Raises:
        Mixed: two units, a unit here and none there, points here and commas there, or 1,234 and nothing that says
            which of the two it is.
    """
    found = _usual(texts)
    if found is not None:
        return found
    bare, units = [], []
    for text in texts:
        split = _split(text)
        if split is None:
            return None
        bare.append(split[0])
        units.append(split[1])
    if len(set(units)) > 1:
        if not set(units) <= {""} | {unit for unit in units if unit.casefold() in UNITS}:
            return None
        one, other = list(dict.fromkeys(units))[:2]
        first, second = texts[units.index(one)], texts[units.index(other)]
        raise Mixed(f"expected one unit in all cells or none, got {first!r} and {second!r}")
    comma = _is_comma(texts, bare, separator)
    values = [_value(text, comma) for text in bare]
    return Numbers(np.array(values), units[0], comma) if None not in values else None


def number(text: str) -> float | None:
    """One cell on its own, a point or a comma as its decimal sign; None if it is no number, or could be two."""
    value = _float(text)
    if value is None and "," in text and "." not in text and not _THOUSANDS.fullmatch(text):
        value = _float(text.replace(",", "."))
    if value is not None or not text:
        return value
    try:
        found = read_numbers([text])
    except Mixed:
        return None
    return None if found is None or found.unit else float(found.values[0])


def each_number(texts: Sequence[str]) -> list[float | None]:
    """`number` of each cell."""
    plain = _plain(texts)
    return list(map(number, texts)) if plain is None else plain.tolist()


def is_number(text: str) -> bool:
    """Whether a cell is a number in some way of writing, and nothing behind it."""
    split = _split(text)
    return split is not None and not split[1] and _value(split[0], POINT.fullmatch(split[0]) is None) is not None


def _usual(texts: Sequence[str]) -> Numbers | None:
    """A column written in one of the usual ways, the same in all cells; None if it takes a look at each of them."""
    first = _split(texts[0]) if len(texts) else None
    unit = first[1] if first else ""
    if unit:
        if not all(text.endswith(unit) for text in texts):
            return None
        texts = [text[: -len(unit)] for text in texts]
    plain = _plain(texts)
    if plain is not None:
        return Numbers(plain, unit)
    if any("." in text for text in texts):
        return None
    texts = [text.strip() for text in texts]
    if not any("," in text and not _THOUSANDS.fullmatch(text) for text in texts):
        return None
    plain = _plain([text.replace(",", ".") for text in texts])
    return None if plain is None else Numbers(plain, unit, comma=True)


def _float(text: str) -> float | None:
    """`_plain` of one cell."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def _plain(texts: Sequence[str]) -> np.ndarray | None:
    """The numbers of a column that are written as Python writes them; 1_000, nan and inf are nobody's numbers here."""
    try:
        values = np.array(list(map(float, texts)))
    except ValueError:
        return None
    return values if np.isfinite(values).all() and "_" not in "".join(texts) else None


def _split(text: str) -> tuple[str, str] | None:
    """A cell as a number, which may still be written in any way, and its unit; None if it begins with no number."""
    text = text.replace("−", "-")
    if "_" in text:
        return None
    if POINT.fullmatch(text) or COMMA.fullmatch(text):
        return text, ""
    match = _WITH_UNIT.fullmatch(text)
    if not match:
        return None
    return (match[1], match[2].strip()) if POINT.fullmatch(match[1]) or COMMA.fullmatch(match[1]) else None


def _is_comma(texts: Sequence[str], bare: Sequence[str], separator: str) -> bool:
    """Whether the comma is the decimal sign of a column."""
    point, comma = ([bool(form.fullmatch(text)) for text in bare] for form in (POINT, COMMA))
    with_points = [i for i, text in enumerate(bare) if "." in text and "," not in text]
    with_commas = [i for i, text in enumerate(bare) if "," in text and "." not in text]
    both = any("." in text and "," in text for text in bare)
    if with_points and with_commas and not both:
        first, second = texts[with_points[0]], texts[with_commas[0]]
        raise Mixed(f"expected one decimal sign, got {first!r} and {second!r}")
    if all(point) and all(comma) and with_commas:
        if separator == ";":
            return True
        raise Mixed(f"expected a point as the decimal sign: {texts[with_commas[0]]!r} can be read in two ways")
    if not all(point) and not all(comma):
        i, j = point.index(False), comma.index(False)
        raise Mixed(f"expected one way of writing numbers, got {texts[i]!r} and {texts[j]!r}")
    return not all(point)


def _value(text: str, comma: bool) -> float | None:
    text = _GROUPS.sub("", text)
    text = text.replace(".", "").replace(",", ".") if comma else text.replace(",", "")
    value = float(text)
    return value if math.isfinite(value) else None
