"""Dirty scans: between reading a file and its Laplacian. What was done to a mesh is told, and which vertex went where.

`mend` keeps every piece, `cut` the faces and `keep` the pieces asked for, `clean` mends and keeps the largest
piece, `unmended` says what of it a mesh needs. The single repairs are in `mending/`: `seams.py` (vertices), `sheets.py`
(faces given twice) and `winding.py`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from lssd_learn.errors import InputError
from lssd_learn.shapes.edges import pieces
from lssd_learn.shapes.mending.seams import seams
from lssd_learn.shapes.mending.sheets import first_of_each, one_side
from lssd_learn.shapes.mending.winding import turned
from lssd_learn.shapes.mesh import Mesh

# A triangle is degenerate when its height is below this share of its longest edge: its cotangents would cost the
# stiffness matrix ten of its sixteen digits.
DEGENERATE = 1e-10


@dataclass(frozen=True, eq=False)
class Cleaned:
    """What was made of a mesh of V vertices.

    Attributes:
        mesh: the cleaned mesh, V' ≤ V vertices, in the order they had.
        vertex_index: (V',) for each vertex of `mesh` the vertex of the original.
        new_index: (V,) for each vertex of the original the vertex of `mesh`, -1 if it was dropped.
        repairs: what was done or found, in short phrases; empty for a clean mesh.
        piece: (V',) for each vertex of `mesh` the number of its connected piece.
        piece_areas: (P,) the areas of all the pieces that were found, the largest first, in square units of length;
            those that were dropped are among them.
    """

    mesh: Mesh
    vertex_index: Int[np.ndarray, " W"]
    new_index: Int[np.ndarray, " V"]
    repairs: tuple[str, ...]
    piece: Int[np.ndarray, " W"]
    piece_areas: Float[np.ndarray, " P"]

    @property
    def dropped(self) -> float:
        """The share of the area, 0 to 1, in pieces that are not in `mesh`."""
        kept = np.unique(self.piece)
        return 0.0 if len(kept) == len(self.piece_areas) else 1 - self.piece_areas[kept].sum() / self.piece_areas.sum()


def clean(mesh: Mesh, name: str = "mesh") -> Cleaned:
    """Mend `mesh` and keep the connected piece of the largest area. A clean mesh comes back as the same object.

    Raises:
        InputError: all faces have zero area.
    """
    return keep(mend(mesh, name))


def mend(mesh: Mesh, name: str = "mesh") -> Cleaned:
    """Every piece of `mesh`, with what can only be a fault of its file put right, and what may trouble its Laplacian.

    In this order: faces that name a vertex twice go (their neighbours close over them); of faces with the same three
    vertices the first stays, and of a sheet whose every face is there once more one side; borders that run along each
    other become one (seams of textures, corners a hair apart); faces that face the other way than their neighbours are
    turned; vertices of no face go. Zero-area faces with three vertices stay, as removing them would cut slits, and so
    do non-manifold edges: both are for the robust Laplacian.

    Args:
        mesh: any mesh.
        name: how an error calls it, a file name perhaps.

    Raises:
        InputError: all faces have zero area.
    """
    if not mesh.area > 0:
        raise InputError(f"{name}: expected a mesh with a surface, all its {len(mesh.faces):,} faces have zero area")
    n, faces, repairs = len(mesh.vertices), mesh.faces, []

    proper = _distinct_corners(faces)
    if not proper.all():
        faces = faces[proper]
        repairs.append(f"removed {_count((~proper).sum(), 'face')} with a repeated vertex")
    faces = _once(faces, repairs)
    single = one_side(mesh.vertices, faces)
    if not single.all():
        faces = faces[single]
        repairs.append(f"kept one side of a sheet with two, removed {_count((~single).sum(), 'face')}")

    new_index, gap = seams(mesh.vertices, faces)
    merged = new_index != np.arange(n)
    if merged.any():
        apart = f" (up to {gap:.2g} apart)" if gap else ""
        repairs.append(f"merged {_count(merged.sum(), 'border vertex')} with others at the same place{apart}")
        faces = new_index[faces]
        faces = _once(faces[_distinct_corners(faces)], repairs)
    turn = turned(faces)
    if turn.any():
        faces = np.where(turn[:, None], faces[:, [0, 2, 1]], faces)
        repairs.append(f"turned {_count(turn.sum(), 'face')} to face as the others do")

    used = np.zeros(n, dtype=bool)
    used[faces] = True
    if not used[new_index].all():
        repairs.append(f"dropped {_count((~used[new_index]).sum(), 'vertex')} of no face")
    if repairs:
        position = np.where(used, np.cumsum(used) - 1, -1)
        mesh, new_index = Mesh(mesh.vertices[used], position[faces]), position[new_index]
    found = {"zero-area face": _degenerate(mesh).sum(), "non-manifold edge": _non_manifold_edges(mesh)}
    left = [_count(number, thing) for thing, number in found.items() if number]
    if left:
        repairs.append(f"left {' and '.join(left)} to the robust Laplacian")
    return Cleaned(mesh, np.flatnonzero(used), new_index, tuple(repairs), *_pieces(mesh))


def cut(whole: Cleaned, stays: Bool[np.ndarray, " F"], told: str) -> Cleaned:
    """Some of the faces that `mend` left, (F,) bool, one of them at least; `told` says why, among the repairs."""
    if stays.all():
        return replace(whole, repairs=(*whole.repairs, told))
    faces = whole.mesh.faces[stays]
    kept = np.zeros(len(whole.mesh.vertices), dtype=bool)
    kept[faces] = True
    mesh, vertex_index, new_index = _with_vertices(whole, kept, faces)
    return Cleaned(mesh, vertex_index, new_index, (*whole.repairs, told), *_pieces(mesh))


def keep(whole: Cleaned, numbers: Sequence[int] = (0,)) -> Cleaned:
    """Some of the pieces that `mend` found, by their numbers: 0 is the one of the largest area.

    Raises:
        InputError: a piece that is not there.
    """
    count = len(whole.piece_areas)
    if not len(numbers) or min(numbers) < 0 or max(numbers) >= count:
        raise InputError(f"pieces: expected some of 0 to {count - 1}, got {list(numbers)}")
    kept = np.isin(whole.piece, numbers)
    if kept.all():
        return whole
    mesh, vertex_index, new_index = _with_vertices(whole, kept, whole.mesh.faces[kept[whole.mesh.faces[:, 0]]])
    chosen = sorted(set(numbers))
    which = "the largest" if chosen == [0] else f"number {', '.join(str(number + 1) for number in chosen)}"
    share = whole.piece_areas[chosen].sum() / whole.piece_areas.sum()
    told = (
        f"kept {which} of {count:,} components, {kept.sum():,} of {len(whole.new_index):,} vertices, "
        f"{100 * share:.3g} % of the area"
    )
    return replace(
        whole,
        mesh=mesh,
        vertex_index=vertex_index,
        new_index=new_index,
        repairs=(*whole.repairs, told),
        piece=whole.piece[kept],
    )


def unmended(mesh: Mesh) -> str:
    """The faults of a mesh that `clean` mends and that its eigenvalues would not show, as a phrase; "" for none."""
    faults = []
    again = int((~first_of_each(mesh.faces)).sum())
    if again:
        faults.append(f"{_count(again, 'face')} given twice")
    into, _ = seams(mesh.vertices, mesh.faces[_distinct_corners(mesh.faces)])
    double = int((into != np.arange(len(into))).sum())
    if double:
        faults.append(
            f"{_count(double, 'border vertex')} where others are, as along the seam of a texture, cut open there"
        )
    return " and ".join(faults)


def is_fit_for_cotangent(mesh: Mesh) -> bool:
    """Whether the cotangent Laplacian is safe: at most two faces an edge, no zero-area face, every vertex in a face."""
    return bool(
        np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)).all()
        and not _degenerate(mesh).any()
        and _non_manifold_edges(mesh) == 0
    )


def _with_vertices(whole: Cleaned, kept: np.ndarray, faces: np.ndarray) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """The mesh of some vertices and faces, `vertex_index` and `new_index` of it."""
    position = np.where(kept, np.cumsum(kept) - 1, -1)
    new_index = np.where(whole.new_index < 0, -1, position[whole.new_index])
    return Mesh(whole.mesh.vertices[kept], position[faces]), whole.vertex_index[kept], new_index


def _pieces(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(V,) which piece each vertex is in, and the areas of the pieces; the largest is 0."""
    count, piece = pieces(mesh.faces, len(mesh.vertices))
    areas = np.bincount(piece[mesh.faces[:, 0]], mesh.face_areas, minlength=count)
    rank = np.empty(count, dtype=np.int64)
    order = np.argsort(-areas, kind="stable")
    rank[order] = np.arange(count)
    return rank[piece], areas[order]


def _once(faces: np.ndarray, repairs: list[str]) -> np.ndarray:
    """Of the faces with the same three vertices the first."""
    first = first_of_each(faces)
    if first.all():
        return faces
    repairs.append(f"removed {_count((~first).sum(), 'face')} given twice")
    return faces[first]


def _distinct_corners(faces: np.ndarray) -> np.ndarray:
    a, b, c = faces.T
    return (a != b) & (b != c) & (c != a)


def _degenerate(mesh: Mesh) -> np.ndarray:
    """(F,) where a face has no area to speak of."""
    a, b, c = mesh.vertices[mesh.faces.T]
    longest = np.maximum.reduce([np.einsum("fx,fx->f", edge, edge) for edge in (b - a, c - b, a - c)])
    return 2 * mesh.face_areas <= DEGENERATE * longest


def _non_manifold_edges(mesh: Mesh) -> int:
    """The number of edges with more than two faces."""
    n, (a, b, c) = len(mesh.vertices), mesh.faces.T
    start, end = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    edges = np.sort(np.minimum(start, end) * n + np.maximum(start, end))
    thrice = edges[2:][edges[2:] == edges[:-2]]
    return len(np.unique(thrice))


def _count(number: int, thing: str) -> str:
    plural = f"{thing[:-2]}ices" if thing.endswith("vertex") else f"{thing}s"
    return f"{number:,} {thing if number == 1 else plural}"
