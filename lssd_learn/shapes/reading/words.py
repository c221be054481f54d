"""Text as it comes: byte order marks, line ends, comments, decimal commas; and what a file is by its first bytes."""

import re
from collections.abc import Iterable

MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_NUMBER_WITH_COMMA = re.compile(r"[+-]?(\d+,\d*|,?\d+)([eE][+-]?\d+)?")
SPACES = ("LPS", "RAS")
_SPACE = re.compile(rb"\bSPACE=(LPS|RAS)\b")
_OTHERS = {
    b"\x1f\x8b": "a gzip archive", b"PK\x03\x04": "a zip archive", b"%PDF": "a PDF", b"\x89PNG": "a picture",
    b"<": "XML or a web page", b"version https://git-lfs": "a pointer of Git LFS, not the file itself",
    b"{": "JSON", b"Kaydara": "FBX",
}  # fmt: skip


def text_of(data: bytes) -> str:
    r"""A file as text: UTF-8, or what its byte order mark says; every line ends in \n.

    Raises:
        ValueError: zero bytes, which no text has, or a mark that does not fit.
    """
    code = next((code for mark, code in MARKS.items() if data.startswith(mark)), "utf-8")
    text = data.decode(code, errors="replace" if code != "utf-16" else "strict")
    if "\0" in text:
        raise ValueError("expected text, it holds zero bytes")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def rows_of(text: str, comment: str = "#") -> tuple[list[list[str]], list[int]]:
    """The words of every line that has any, without comments, and the numbers of these lines, from 1."""
    rows, numbers = [], []
    for number, line in enumerate(text.split("\n"), 1):
        words = line.split(comment, 1)[0].split() if comment else line.split()
        if words:
            rows.append(words)
            numbers.append(number)
    return rows, numbers


class Numbers:
    """Reads numbers, with decimal commas too as long as no number of the file has a point."""

    def __init__(self):
        self.commas = self._points = False

    def floats(self, words: Iterable[str]) -> list[float]:
        """Raises ValueError for a word that is no number."""
        words = list(words)
        try:
            found = [float(word) for word in words]
        except ValueError:
            if not all(_NUMBER_WITH_COMMA.fullmatch(word) for word in words):
                raise
            self.commas = True
            found = [float(word.replace(",", ".")) for word in words]
        if any("_" in word for word in words):
            raise ValueError("a number with a line under it")
        self._points = self._points or any("." in word for word in words)
        if self.commas and self._points:
            raise ValueError("numbers with decimal commas beside numbers with points")
        return found

    @property
    def notes(self) -> tuple[str, ...]:
        return ("decimal commas taken for points",) if self.commas else ()


def whole(word: str) -> int:
    """A whole number, written with digits and a sign only."""
    if not re.fullmatch(r"[+-]?\d{1,18}", word):
        raise ValueError(f"expected a whole number, got {word[:30]!r}")
    return int(word)


def what_it_is(data: bytes) -> str:
    """The suffix of the format that a file is by its first bytes; "" if they do not tell.

    Raises:
        ValueError: it is none of ours, and says so.
    """
    if data.startswith(b"# vtk DataFile"):
        return ".vtk"
    if data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") and b"<VTKFile" in data[:4096]:
        return ".vtp"
    for start, kind in _OTHERS.items():
        if data.startswith(start):
            raise ValueError(f"it is {kind}")
    if data.startswith(b"glTF"):
        return ".glb"
    head = data[:4096]
    try:
        head = text_of(head[: len(head) // 2 * 2]).lstrip()
    except (ValueError, UnicodeError):
        head = head.decode("latin-1").lstrip()
    if re.match(r"ply\s", head):
        return ".ply"
    if re.match(r"(#.*\s+)*(ST)?[CN]{0,2}4?n?OFF(\s|\d|$)", head):
        return ".off"
    if re.match(r"solid\b[^\n\r]*\s+facet\s", head, re.IGNORECASE):
        return ".stl"
    return ""


def space_of(data: bytes) -> str:
    """The coordinate system that 3D Slicer writes into the header or a comment, "LPS" or "RAS"; "" without."""
    found = _SPACE.search(data[:4096])
    return found[1].decode() if found else ""


def tail(data: bytes, least: int) -> tuple[str, ...]:
    """The note on bytes that are left behind a binary shape.

    Raises:
        ValueError: so many, `least` or more, that they may be a part of it, and not all of them zero.
    """
    if len(data) >= least and data.strip(b"\0"):
        raise ValueError(f"{len(data):,} bytes more than it announces")
    return (f"left out {len(data):,} bytes behind its end",) if data else ()
