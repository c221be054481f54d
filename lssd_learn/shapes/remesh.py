"""Another mesh of the same surface, by random edge collapses: what a second scanner would have made of the shape.

Its vertices lie on the triangles of the first mesh and it remembers where, so that maps computed between such meshes
can be scored.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int
from scipy.sparse import csr_array

from lssd_learn.errors import check_whole
from lssd_learn.shapes.edges import edge_lengths
from lssd_learn.shapes.mesh import Mesh
from lssd_learn.shapes.triangles import triangle_normals

SPREAD = 0.5  # standard deviation of the logarithm by which an edge is taken for shorter or longer than it is
TURN = 0.5  # least cosine between the normals of a triangle before and after
ROUND = 0.2  # least quality of a triangle after, unless it was worse before: 1 is equilateral, 0 a line
SHARE = 0.15  # of the edges, the ones that look shortest, that may collapse in a round
PATIENCE = 3  # rounds without a collapse after which no more are to be had
SLIDE = 0.45  # of the way from a vertex to the opposite edge of a triangle: below half, so that it stays the nearest


@dataclass(frozen=True, eq=False)
class Remeshed:
    """A mesh and where its W vertices come from.

    Attributes:
        mesh: of the same surface, nearly.
        origins: (W,) for each of its vertices the one of the first mesh that it stands beside; no two alike.
    """

    mesh: Mesh
    origins: Int[np.ndarray, " W"]


def remesh(mesh: Mesh, vertices: int, rng: np.random.Generator) -> Remeshed:
    """Collapse short edges, chosen with much randomness, until `vertices` are left; these move a little, in the
    triangles around them, and come in random order.

    Each edge shrinks to one of its ends. The topology stays what it is (link condition: Dey, Edelsbrunner, Guha &
    Nekhayev 1999), no triangle turns over, borders and non-manifold edges are left alone. Many edges, no two of them
    near each other, collapse at once.

    Args:
        mesh: V vertices.
        vertices: 4 to V; more are left where no further collapse is possible.
        rng: of everything random.

    Raises:
        InputError: `vertices` out of range.
    """
    check_whole("vertices", vertices, 4, len(mesh.vertices))
    P, F = mesh.vertices, mesh.faces
    left, idle = len(np.unique(F)), 0
    while left > vertices and idle < PATIENCE:
        ends, kept = _candidates(P, F, rng)
        good = np.flatnonzero(_harmless(P, F, ends, kept))[: left - vertices]
        ends, kept = ends[good], kept[good]
        into = np.arange(len(P))
        into[ends] = kept[:, None]
        F = into[F]
        F = F[(np.roll(F, 1, axis=1) != F).all(axis=1)]
        left -= len(kept)
        idle = 0 if len(kept) else idle + 1
    origins = rng.permutation(np.unique(F))
    number = np.empty(len(P), dtype=np.int64)
    number[origins] = np.arange(len(origins))
    F = number[F][rng.permutation(len(F))]
    return Remeshed(Mesh(_slid(mesh, F, origins, rng), F), origins)


def _candidates(P: np.ndarray, F: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Edges (m, 2) whose collapse keeps the topology, no two with adjacent ends, the ones that look shortest first, and
    the ends (m,) they would shrink to."""
    n = len(P)
    sides = np.sort(np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]]), axis=1)
    codes, faces_at = np.unique(sides[:, 0] * n + sides[:, 1], return_counts=True)
    E = np.stack(np.divmod(codes, n), axis=1)
    A = csr_array((np.ones(2 * len(E)), (E.ravel(), E[:, ::-1].ravel())), shape=(n, n))
    inner = np.ones(n, dtype=bool)
    inner[E[faces_at != 2]] = False
    E = E[((A @ A)[E[:, 0], E[:, 1]] == 2) & inner[E].all(axis=1)]
    looks = np.log(np.maximum(edge_lengths(P, E), np.finfo(float).tiny)) + SPREAD * rng.standard_normal(len(E))
    E = E[np.argsort(looks, kind="stable")[: math.ceil(SHARE * len(E))]]
    rank = np.full(n, len(E))  # of the shortest edge at a vertex, then at any of its neighbours too
    np.minimum.at(rank, E.ravel(), np.repeat(np.arange(len(E)), 2))
    near = rank.copy()
    np.minimum.at(near, np.repeat(np.arange(n), np.diff(A.indptr)), rank[A.indices])
    chosen = E[(near[E] == np.arange(len(E))[:, None]).all(axis=1)]
    return chosen, chosen[np.arange(len(chosen)), rng.integers(2, size=len(chosen))]


def _harmless(P: np.ndarray, F: np.ndarray, ends: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Which of the collapses turn no triangle over and leave none a sliver."""
    moved, edge = P.copy(), np.full(len(P), -1)
    moved[ends] = P[kept][:, None]
    edge[ends] = np.arange(len(ends))[:, None]
    at = edge[F].max(axis=1)  # two of the edges have no triangle in common: their ends would be adjacent
    stays = (edge[F] >= 0).sum(axis=1) == 1
    harmless = np.ones(len(ends), dtype=bool)
    harmless[at[stays][_spoilt(P, moved, F[stays])]] = False
    return harmless


def _slid(mesh: Mesh, F: np.ndarray, origins: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Positions (W, 3) of the vertices, each somewhere in a random triangle of the first mesh at its origin, less far
    or not at all where that would spoil one of the new triangles F."""
    corner = np.full(len(mesh.vertices), -1)
    order = rng.permutation(mesh.faces.size)
    corner[mesh.faces.ravel()[order]] = order  # of a vertex with several triangles the last one counts
    face, place = np.divmod(corner[origins], 3)
    first, second, third = (mesh.vertices[mesh.faces[face, (place + turn) % 3]] for turn in range(3))
    way, across = SLIDE * rng.random((len(origins), 1)), rng.random((len(origins), 1))
    moved = first + way * ((1 - across) * second + across * third - first)
    for less in (0.5, 0.5, 0.5, 0, *PATIENCE * [0]):
        back = np.unique(F[_spoilt(first, moved, F)])
        moved[back] = first[back] + less * (moved[back] - first[back])
    return moved


def _spoilt(P: np.ndarray, moved: np.ndarray, F: np.ndarray) -> np.ndarray:
    """(f,) which triangles turn over or become slivers as the vertices move."""
    (before, was), (after, now) = _normals(P, F), _normals(moved, F)
    return (np.einsum("fx,fx->f", before, after) < TURN) | (now < np.minimum(ROUND, was))


def _normals(P: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (f, 3) and qualities (f,) in [0, 1] of triangles."""
    p, q, r = P[F.T]
    normal = triangle_normals(P[F])
    twice = np.linalg.norm(normal, axis=1)
    squares = sum(np.einsum("fx,fx->f", d, d) for d in (q - p, r - q, p - r))
    tiny = np.finfo(float).tiny
    return normal / np.maximum(twice, tiny)[:, None], 2 * np.sqrt(3) * twice / np.maximum(squares, tiny)
