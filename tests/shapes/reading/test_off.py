"""OFF in the forms that programs write."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import load


@pytest.fixture
def write(draft, dressed, numbers):
    def make(rng):
        shape = draft(rng, exact=True)
        words, vertices = numbers(shape.vertices, rng)
        kind = rng.choice(["", "", "", "C", "N", "CN", "ST"])
        comma = any("," in word for word in words[0])
        point = (lambda x: f"{x:.3f}".replace(".", ",")) if comma else (lambda x: f"{x:.3f}")
        for row in words:
            row += [point(x) for x in rng.random(3)] if "N" in kind else []
            row += ["200", "100", "0", "255"] if "C" in kind else []
            row += ["0", point(0.25)] if kind == "ST" else []
        colour = [[], [], ["7"], ["255", "0", "0"], [point(0.5)] * 4][rng.integers(5)]
        wrapped = not kind and not colour and rng.random() < 0.3
        polygons = [[len(p), *p] for p in shape.polygons]
        if rng.random() < 0.2:
            polygons.insert(int(rng.integers(len(polygons))), [2, 0, 1])
        faces = [[*map(str, p), *colour] for p in polygons]
        counts = [str(len(words)), str(len(faces))] + (["0"] if rng.random() < 0.7 else [])
        if wrapped:
            flat = [word for row in [*words, *faces] for word in row]
            width = int(rng.integers(2, 9))
            rows = [flat[i : i + width] for i in range(0, len(flat), width)]
        else:
            rows = [*words, *faces]
        lines = [rng.choice([" ", "\t", "  "]).join(row) for row in rows]
        if rng.random() < 0.4:
            lines = [line + (" # a comment" if rng.random() < 0.2 else "") for line in lines]
        if rng.random() < 0.4:
            for at in rng.integers(len(lines), size=3):
                lines.insert(at, rng.choice(["", "# OFF 3 1 0", "   "]))
        head = f"{kind}OFF" + rng.choice(["\n", " # made by hand\n", "\n\n", " "]) + " ".join(counts)
        if not kind and rng.random() < 0.1:
            head = head.replace("OFF ", "OFF")  # as some have it
        if not kind and rng.random() < 0.1:
            head = " ".join(counts) if len(counts) == 3 else head
        text = head + "\n" + "\n".join(lines) + rng.choice(["", "\n", "\n\n# end\n"])
        return dressed(text, rng), shape.expected(vertices), f"{kind} {colour} wrapped={wrapped}"

    return make


def test_some_files(sweep, write):
    sweep(".off", write, 12, seed=0).check(least=0.99)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".off", write, 400, seed=1).check(least=0.99)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("4OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n", "4OFF has other than three coordinates"),
        ("nOFF 3\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "nOFF has other than three coordinates"),
        ("OFF BINARY\n3 1 0\n", "binary OFF"),
        ("OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n", "OFF with 4 numbers a vertex"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n", "it announces 3 vertices and 1 faces"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 9\n", "line 6 does not fit: '3 0 1 2 9 9'"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "faces: expected indices from 0 to 2"),
        ("OFF\n3 1 0\n0,5 0 0\n1.5 0 0\n0 1 0\n3 0 1 2\n", "line 4 does not fit: '1.5 0 0'"),
        ("OFF\n3 1 0\n0 0 0\n1 0\n0 0 1\n3 0 1 2\n", "it announces 3 vertices and 1 faces"),
        ("OFF\n4 1 0\n0 0 0\n1 1 0\n1 0 0\n0 1 0\n4 0 1 2 3\n", "a face crosses itself"),
    ],
)
def test_refused(tmp_path, text, message):
    (tmp_path / "a.off").write_text(text)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.off")


def test_what_is_left_out_or_guessed_is_told(tmp_path, caplog):
    (tmp_path / "a.off").write_text("OFF\n3 2 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n")
    np.testing.assert_allclose(load(tmp_path / "a.off").area, 0.25)
    assert "left out 1 face of fewer than three corners, decimal commas taken for points" in caplog.text
