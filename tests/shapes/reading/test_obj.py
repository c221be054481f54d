"""OBJ in the forms that programs write."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import load


@pytest.fixture
def write(draft, dressed, numbers):
    def make(rng):
        shape = draft(rng, exact=True)
        words, vertices = numbers(shape.vertices, rng)
        behind = [[], [], ["1"], ["1", "0", "0"], ["1", "1", "0", "0"]][rng.integers(5)]
        space = rng.choice([" ", "\t", "  "])
        name = "V" if rng.random() < 0.1 else "v"
        vertex_lines = [space.join([name, *row, *behind]) for row in words]
        form = rng.choice(["{}", "{}/1", "{}/1/1", "{}//1"])
        negative, early = rng.random() < 0.3, rng.random() < 0.3
        n = len(vertex_lines)

        def face(polygon, there):
            corners = [form.format(v - there if negative and there > v else v + 1) for v in polygon]
            line = space.join(["f", *corners])
            if rng.random() < 0.1:
                at = line.rindex(space)
                line = line[:at] + " \\\n" + line[at:]
            return line + (" # a face" if rng.random() < 0.1 else "")

        polygons = list(shape.polygons)
        lines = [] if form == "{}" else ["vt 0.5 0.5", "vn 0 0 1"]
        if early:  # faces right behind the last of their vertices
            for i, line in enumerate(vertex_lines):
                lines.append(line)
                lines += [face(p, i + 1) for p in polygons if max(p) == i]
        else:
            lines += vertex_lines + [face(p, n) for p in polygons]
        extras = ["# v 9 9 9", "o a", "g a b", "s off", "usemtl m", "", "  ", "f 1 2", "l 1 2 3", "p 1", "# C:\\dir\\"]
        for extra in rng.choice(extras, size=rng.integers(4)):
            lines.insert(int(rng.integers(n if not early else 1, len(lines) + 1)), str(extra))
        lines.insert(0, rng.choice(["# OBJ", "mtllib a.mtl", "o thing"]))
        # A line that goes on must stay with the next.
        text = "\n".join(lines) + rng.choice(["", "\n"])
        return dressed(text, rng), shape.expected(vertices), f"{form} negative={negative} early={early} {behind}"

    return make


def test_some_files(sweep, write):
    sweep(".obj", write, 12, seed=0).check(least=0.99)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".obj", write, 400, seed=1).check(least=0.99)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0 2\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n", "line 1 is no vertex or face: 'v 0 0 0 2'"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4 is no vertex or face"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -1 -2\n", "line 4 is no vertex or face"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n3\n", "line 5 is no vertex or face: '3'"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\ncstype bspline\nf 1 2 3\n", "line 4 is of a curved surface, which is not read"),
        ("v 1_0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1 is no vertex or face"),
        ("v 0,5 0 0\nv 1.5 0 0\nv 0 1 0\nf 1 2 3\n", "line 2 is no vertex or face"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\", "line 4 goes on behind the end of the file"),
    ],
)
def test_refused(tmp_path, text, message):
    (tmp_path / "a.obj").write_text(text)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.obj")


def test_a_comment_does_not_go_on(tmp_path):
    (tmp_path / "a.obj").write_text("# C:\\scans\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    np.testing.assert_allclose(load(tmp_path / "a.obj").area, 0.5)


def test_what_is_left_out_is_told(tmp_path, caplog):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\nl 1 2 3\nwarp 1\n")
    load(tmp_path / "a.obj")
    assert "1 face of fewer than three corners, left out 1 line, left out 1 line that start with 'warp'" in caplog.text
