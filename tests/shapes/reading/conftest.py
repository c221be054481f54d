"""Shapes as people have them, drawn at random, and the judge of what a reader makes of their files.

Each test file here writes one format in any way it allows. A file is right if, read and cleaned, its area and
eigenvalues are those of the shape built in memory; otherwise it has to be refused.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
import trimesh

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, clean, eigenbasis, load

K, TOLERANCE = 6, 1e-6


@dataclass
class Draft:
    """What is to be written, and which shape is meant: `meant` triangles of `vertices`, whatever the faults."""

    vertices: np.ndarray
    polygons: list[list[int]]
    meant: np.ndarray

    def expected(self, vertices: np.ndarray | None = None) -> Mesh:
        """The shape in memory, with the vertices as they were written."""
        used, faces = np.unique(self.meant, return_inverse=True)
        return Mesh((self.vertices if vertices is None else vertices)[used], faces.reshape(-1, 3))


def bumpy(subdivisions: int = 2) -> tuple[np.ndarray, np.ndarray]:
    sphere = trimesh.creation.icosphere(subdivisions)
    x, y, z = np.array(sphere.vertices).T
    radius = 1 + 0.2 * np.sin(2 * x + 1) * np.cos(3 * y + 0.5) + 0.15 * z * x + 0.1 * z
    return (radius * [x, 1.3 * y, 0.8 * z]).T, np.array(sphere.faces)


def cut_open(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A connected part with a border."""
    used, inverse = np.unique(faces[vertices[faces].mean(axis=1)[:, 2] > -0.4], return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3)


def seam(vertices: np.ndarray, faces: np.ndarray, gap: float = 0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices between two halves are there twice, the second time a little further."""
    beyond = vertices[faces].mean(axis=1)[:, 0] > 0
    shared = np.intersect1d(faces[beyond], faces[~beyond])
    number = np.arange(len(vertices))
    number[shared] = len(vertices) + np.arange(len(shared))
    faces = np.where(beyond[:, None], number[faces], faces)
    return np.vstack([vertices, vertices[shared] + gap * np.ptp(vertices, axis=0).max()]), faces


def paired(faces: np.ndarray, vertices: np.ndarray, rng: np.random.Generator, share: float) -> list[list[int]]:
    """Some neighbours as quads whose first corner's fan they are."""
    by_edge, polygons = {}, []
    for f in rng.permutation(len(faces)):
        face = [int(v) for v in faces[f]]
        for turn in range(3):
            a, b, c = np.roll(face, turn).tolist()
            other = by_edge.get((b, a)) if rng.random() < share else None
            if other is not None and polygons[other[0]] is not None:
                n, d = other  # the edge between is a to b: cut from there, the quad gives both again
                normals = [
                    np.cross(vertices[q] - vertices[p], vertices[r] - vertices[p]) for p, q, r in ((a, d, b), (a, b, c))
                ]
                if normals[0] @ normals[1] > 0:
                    polygons[n] = None
                    polygons.append([a, d, b, c])
                    break
        else:
            polygons.append(face)
            for turn in range(3):
                a, b, c = np.roll(face, turn).tolist()
                by_edge[a, b] = len(polygons) - 1, c
    return [polygon for polygon in polygons if polygon is not None]


@pytest.fixture(scope="session")
def draft() -> Callable[..., Draft]:
    """A function (rng, exact, faults) → a shape to write; `exact` if the writer keeps every digit."""

    def make(rng: np.random.Generator, exact: bool, faults: bool = True, polygons: bool = True) -> Draft:
        vertices, faces = bumpy()
        if rng.random() < 0.3:
            vertices, faces = cut_open(vertices, faces)
        vertices = vertices * 10.0 ** rng.integers(-2, 4)
        if exact and rng.random() < 0.2:
            vertices = vertices + rng.uniform(-1, 1, 3) * 3e4 * np.ptp(vertices, axis=0).max()
        meant, n = faces, len(vertices)
        kind = (
            rng.choice(["none", "none", "twice", "sides", "winding", "seam", "hair", "unused", "piece"])
            if faults
            else "none"
        )
        if kind == "twice":
            faces = np.vstack([faces, faces[rng.integers(len(faces), size=9)]])
        elif kind == "sides":
            own = n if rng.random() < 0.5 else 0  # with vertices of its own or not
            faces = np.vstack([faces, faces[:, ::-1] + own])
            vertices = np.vstack([vertices, vertices]) if own else vertices
        elif kind == "winding":
            some = rng.random(len(faces)) < 0.2
            faces = np.where(some[:, None], faces[:, ::-1], faces)
        elif kind in ("seam", "hair"):
            vertices, faces = seam(vertices, faces, 1e-9 if kind == "hair" and exact else 0)
        elif kind == "unused":
            vertices = np.vstack([vertices, vertices[:3] + 1])
        elif kind == "piece":
            size = np.ptp(vertices, axis=0).max()
            extra = size * 0.02 * np.eye(4)[:, :3] + vertices.max(axis=0) + size
            faces = np.vstack([faces, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(vertices)])
            vertices = np.vstack([vertices, extra])
        share = rng.choice([0, 0.5, 1]) if polygons and kind in ("none", "seam", "hair", "unused") else 0
        return Draft(vertices, paired(faces, vertices, rng, share), meant)

    return make


@pytest.fixture(scope="session")
def dressed() -> Callable[[str, np.random.Generator], bytes]:
    """A function (text, rng) → bytes, with any line ends and byte order mark."""

    def make(text: str, rng: np.random.Generator, marks: bool = True) -> bytes:
        text = text.replace("\n", ["\n", "\n", "\r\n", "\r"][rng.integers(4)])
        code = ["utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16"][rng.integers(5)] if marks else "utf-8"
        return text.encode(code)

    return make


@pytest.fixture(scope="session")
def numbers() -> Callable[[np.ndarray, np.random.Generator], tuple[list[list[str]], np.ndarray, bool]]:
    """A function (table, rng) → its numbers as words, what these say, and whether every digit is there."""

    def make(table: np.ndarray, rng: np.random.Generator, commas: bool = True):
        form = ["%.17g", "%.17g", "%.16e", "%.17G", "%+.17e"][rng.integers(5)]
        words = [[form % x for x in row] for row in table]
        if commas and rng.random() < 0.15:
            words = [[word.replace(".", ",") for word in row] for row in words]
        return words, table

    return make


@dataclass
class Tally:
    """What became of the files of a sweep."""

    right: int = 0
    refused: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def check(self, least: float) -> None:
        """Nothing was read as something else, and so great a share at least was read."""
        tried = self.right + len(self.refused) + len(self.wrong)
        print(
            f"{tried} files: {self.right} right, {len(self.refused)} refused, {len(self.wrong)} read as something else"
        )
        assert not self.wrong, "\n".join([f"{len(self.wrong)} of {tried} read as something else:", *self.wrong[:10]])
        assert not any("\n" in line for line in self.refused)
        assert self.right >= least * tried, "\n".join([f"only {self.right} of {tried}:", *self.refused[:10]])


def differs(path, expected: Mesh | PointCloud) -> str:
    """How the shape in a file differs from the one in memory, "" if it does not. Raises InputError if refused."""
    found = load(path)
    if type(found) is not type(expected):
        return f"a {type(found).__name__}"
    if isinstance(found, PointCloud):
        same = found.points.shape == expected.points.shape and np.allclose(found.points, expected.points, rtol=1e-12)
        return "" if same else "other points"
    found = clean(found).mesh
    if not abs(found.area / expected.area - 1) < TOLERANCE:
        return f"area {found.area:.9g}, not {expected.area:.9g}"
    ours, theirs = eigenbasis(found, K).evals, eigenbasis(expected, K).evals
    if not np.allclose(ours, theirs, rtol=TOLERANCE, atol=TOLERANCE * theirs[1]):
        return f"eigenvalues {ours}, not {theirs}"
    return ""


@pytest.fixture
def sweep(tmp_path, caplog):
    """A function (suffix, write, n, seed) → tally; write(rng) gives the bytes, the shape meant and a name."""
    caplog.set_level("ERROR")

    def run(suffix: str, write: Callable, n: int, seed: int) -> Tally:
        tally = Tally()
        for i in range(n):
            data, expected, name = write(np.random.default_rng([seed, i]))
            path = tmp_path / f"{i}{suffix}"
            path.write_bytes(data)
            try:
                fault = differs(path, expected)
            except InputError as error:
                tally.refused.append(f"{i} {name}: {error}")
                continue
            if fault:
                tally.wrong.append(f"{i} {name}: {fault}")
            else:
                tally.right += 1
        return tally

    return run
