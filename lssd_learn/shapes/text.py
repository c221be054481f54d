"""Plain text formats for `files`: OBJ and XYZ are read, OFF, OBJ and XYZ written, every digit and vertex kept.

Trimesh reads an OBJ for rendering: texture seams and materials duplicate and reorder its vertices, which would break
the correspondence of a collection. Its writers round to a fixed number of decimals, whatever the units.
"""

import io

import numpy as np

from lssd_learn.shapes.mesh import PointCloud, Shape


def read_obj(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces in the order of the file; polygons become fans; texture, normals and groups are left out.

    Returns:
        vertices (V, 3) float64 and faces (F, 3) int64, either possibly empty.

    Raises:
        ValueError: a line that cannot be understood, with its number.
    """
    vertices, faces = [], []
    for number, line in enumerate(text.replace("\\\n", " ").splitlines(), 1):
        kind, *words = line.split() or [""]
        try:
            if kind == "v":
                vertices.append([float(word) for word in words[:3]])
                if len(words) < 3:
                    raise ValueError
            elif kind == "f":
                corners = [_index(word, len(vertices)) for word in words]
                if len(corners) < 3:
                    raise ValueError
                faces.extend((corners[0], b, c) for b, c in zip(corners[1:], corners[2:], strict=False))
        except ValueError:
            raise ValueError(f"line {number} is no vertex or face: {line[:60]!r}") from None
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), np.array(faces, dtype=np.int64).reshape(-1, 3)


def _index(word: str, n_vertices: int) -> int:
    """The 0-based vertex of an OBJ corner such as `7`, `7/1/2` or `-1` (the latest vertex)."""
    index = int(word.split("/")[0])
    return index - 1 if index > 0 else n_vertices + index


def read_xyz(text: str) -> np.ndarray:
    """The first three numbers of every line, (V, 3) float64; blank lines and `#` comments are skipped.

    Raises:
        ValueError: a line with fewer than three numbers.
    """
    points = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        try:
            x, y, z = (float(word) for word in words[:3])
        except ValueError:
            raise ValueError(f"line {number} does not start with three numbers: {line[:60]!r}") from None
        points.append((x, y, z))
    return np.array(points, dtype=np.float64).reshape(-1, 3)


def write_off(shape: Shape) -> str:
    """OFF; a cloud has zero faces."""
    faces = _face_array(shape)
    head = f"OFF\n{len(shape.vertices)} {len(faces)} 0\n"
    return head + _rows(shape.vertices, "%.17g %.17g %.17g") + _rows(faces, "3 %d %d %d")


def write_obj(shape: Shape) -> str:
    """OBJ; a cloud has vertices only."""
    return _rows(shape.vertices, "v %.17g %.17g %.17g") + _rows(_face_array(shape) + 1, "f %d %d %d")


def write_xyz(shape: Shape) -> str:
    """One line a point."""
    return _rows(shape.vertices, "%.17g %.17g %.17g")


def _face_array(shape: Shape) -> np.ndarray:
    return np.empty((0, 3), dtype=np.int64) if isinstance(shape, PointCloud) else shape.faces


def _rows(array: np.ndarray, form: str) -> str:
    text = io.StringIO()
    np.savetxt(text, array, fmt=form)
    return text.getvalue()
