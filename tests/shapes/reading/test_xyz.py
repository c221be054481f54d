"""XYZ in the forms that scanners write."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import PointCloud, load


@pytest.fixture
def write(dressed, numbers):
    def make(rng):
        points = rng.standard_normal((40, 3)) * 10.0 ** rng.integers(-3, 5) + rng.choice([0, 0, 5e5])
        words, points = numbers(points, rng)
        commas = "," in words[0][0]
        point = (lambda x: f"{x:.6f}".replace(".", ",")) if commas else (lambda x: f"{x:.6f}")
        kind = rng.choice(["", "", "normals", "colours", "floats", "intensity", "both", "pts"])
        for row in words:
            normal = rng.standard_normal(3)
            if kind in ("normals", "both"):
                row += [point(x) for x in normal / np.linalg.norm(normal)]
            if kind == "intensity" or kind == "pts":
                row += [point(rng.random() * 9)]
            if kind in ("colours", "both", "pts"):
                row += [str(x) for x in rng.integers(256, size=3)]
            if kind == "floats":
                row += [point(x) for x in rng.random(3)]
        separators = [" ", "\t", ";", "; ", "   "] + ([] if commas else [",", ", "])
        separator = str(rng.choice(separators))
        lines = [
            separator.join(row) + (separator.strip() if rng.random() < 0.1 and separator.strip() == ";" else "")
            for row in words
        ]
        if rng.random() < 0.3:
            lines = [" " + line + "  " for line in lines]
        for at in rng.integers(1, len(lines), size=rng.integers(3)):
            lines.insert(at, rng.choice(["", "# 1 2 3", "// a", "   "]))
        head = rng.choice(["", "", "# made by hand\n", "//X Y Z\n", "count", "names"])
        if head == "count":
            head = f"{len(words)}\n"
        elif head == "names":
            more = [f"c{i}" for i in range(len(words[0]) - 3)]
            head = separator.join(["X", "Y", "Z", *more]) + "\n"
        text = head + "\n".join(lines) + rng.choice(["", "\n", "\n\n"])
        return dressed(text, rng), PointCloud(points), f"{kind} {separator!r} {head!r}"

    return make


def test_some_files(sweep, write):
    sweep(".xyz", write, 40, seed=0).check(least=0.97)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".xyz", write, 1000, seed=1).check(least=0.97)


ROWS = np.random.default_rng(0).standard_normal((5, 3)).round(3).tolist()


def rows(form: str) -> str:
    return "".join(form.format(*row, i=i) for i, row in enumerate(ROWS))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (rows("{i} {0} {1} {2}\n"), "its first column counts the lines"),
        (rows("{0} {1} {2} {0} {1}\n"), "2 columns behind x y z are neither normals nor colours"),
        (rows("{0} {1} {2} 7 300 -4\n"), "3 columns behind x y z are neither normals nor colours"),
        ("5\nwater\n" + rows("O {0} {1} {2}\n"), "does not start with three numbers: 'water'"),
        ("7\n" + rows("{0} {1} {2}\n"), "it announces 7 points, 5 are there"),
        (rows("{0} {1} {2}\n") + "1 2 3 4\n", "line 6 has 4 columns, the first has 3"),
        ("1,5,2,5,3,5\n7,5,3,5,4,5\n", "its commas may be decimal or separate"),
        ("1,5 2,5 3.5\n", "does not start with three numbers"),
        ("1.234,5 2 3\n", "does not start with three numbers"),
        ("1 2 3\0\n", "it holds zero bytes"),
    ],
)
def test_refused(tmp_path, text, message):
    (tmp_path / "a.xyz").write_text(text)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.xyz")


def test_names_tell_which_columns_are_meant(tmp_path, caplog):
    (tmp_path / "a.xyz").write_text("id;Z;X;Y\n1;3;1;2\n2;6;4;5\n")
    assert load(tmp_path / "a.xyz").points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert "columns id left out" in caplog.text


def test_decimal_commas(tmp_path, caplog):
    (tmp_path / "a.xyz").write_text("1,5 2,5 3\n4 5 6,25\n")
    assert load(tmp_path / "a.xyz").points.tolist() == [[1.5, 2.5, 3], [4, 5, 6.25]]
    assert "decimal commas taken for points" in caplog.text
