"""Polygons of any form into triangles: convex or not, flat or bent. Every corner is kept, so that neighbours fit.

A polygon becomes the fan of its first corner where that is right, whatever its form: shapes with the same polygons
then have the same triangles. Where it is not, ears are cut off.
"""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.shapes.mesh import LARGEST
from lssd_learn.shapes.reading.parsed import some
from lssd_learn.shapes.triangles import triangle_normals

FLAT = 1e-10  # a triangle's height over its longest edge, below which it has no area to speak of
FOLDED = -0.99  # cosine between the two halves of a quad, below which it crosses itself
CROSSED = "a face crosses itself: how it is meant cannot be told"


def triangles(
    vertices: Float[np.ndarray, "V 3"], corners: Int[np.ndarray, " C"], counts: Int[np.ndarray, " P"]
) -> tuple[Int[np.ndarray, "F 3"], tuple[str, ...]]:
    """Faces (F, 3) int64 in the order of the polygons, and what was left out.

    Args:
        vertices: (V, 3).
        corners: (C,) the corners of all polygons, one polygon after the other.
        counts: (P,) how many corners each has; those with fewer than three different ones are left out.

    Raises:
        ValueError: a corner that is no vertex, a polygon that crosses itself.
    """
    corners, counts = np.asarray(corners, dtype=np.int64), np.asarray(counts, dtype=np.int64)
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        low, high = corners.min(), corners.max()
        raise ValueError(f"faces: expected indices from 0 to {len(vertices) - 1}, got some from {low} to {high}")
    starts = np.cumsum(counts) - counts
    own = np.arange(len(counts))
    parts, owners = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]

    def put(part: np.ndarray, polygons: np.ndarray) -> None:
        parts.append(part.reshape(-1, 3))
        owners.append(np.repeat(polygons, part.shape[1]))

    three = own[counts == 3]
    put(corners[starts[three][:, None] + np.arange(3)][:, None], three)
    skipped = int((counts < 3).sum())
    for n in np.unique(counts[counts > 3]):
        which = own[counts == n]
        at = corners[starts[which][:, None] + np.arange(n)]
        proper = (at != np.roll(at, 1, axis=1)).all(axis=1)
        for polygon, row in zip(which[~proper], at[~proper], strict=True):  # a corner named twice in a row
            row = row[row != np.roll(row, 1)]
            if len(row) < 3:
                skipped += 1
            else:
                put(_cut(vertices, row[None]), np.array([polygon]))
        if proper.any():
            put(_cut(vertices, at[proper]), which[proper])
    faces, owner = np.concatenate(parts), np.concatenate(owners)
    notes = (f"left out {some(skipped, 'face')} of fewer than three corners",) if skipped else ()
    return faces[np.argsort(owner, kind="stable")], notes


def unrolled(strip: Int[np.ndarray, " S"]) -> Int[np.ndarray, "F 3"]:
    """(F, 3) the triangles of a strip; −1 begins another one. Every second one runs the other way."""
    found = []
    for part in np.split(strip, np.flatnonzero(strip < 0)):
        part = part[part >= 0]
        cut = np.stack([part[:-2], part[1:-1], part[2:]], axis=1) if len(part) > 2 else np.empty((0, 3), np.int64)
        cut[1::2] = cut[1::2, [1, 0, 2]]
        found.append(cut[(cut != np.roll(cut, 1, axis=1)).all(axis=1)])  # a corner twice joins two strips
    return np.concatenate(found)


def _cut(vertices: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(P, n − 2, 3) the triangles of polygons with n corners each (P, n)."""
    n = corners.shape[1]
    if n == 3:
        return corners[:, None]
    places = np.array([[0, i, i + 1] for i in range(1, n - 1)])
    cut, points = corners[:, places], vertices[corners]
    if not (np.abs(points) < LARGEST).all():
        return cut  # refused later, with the vertex
    if n == 4:
        fan, other = (_halves(np.roll(points, -turn, axis=1)) for turn in (0, 1))
        swap = (fan < 0) & (other > fan)
        if (np.where(swap, other, fan) < FOLDED).any():
            raise ValueError(CROSSED)
        cut[swap] = corners[swap][:, [[1, 2, 3], [1, 3, 0]]]
        return cut
    for i in np.flatnonzero(~_fans(vertices, cut)):
        cut[i] = corners[i][ears(vertices[corners[i]])]
    return cut


def _halves(points: np.ndarray) -> np.ndarray:
    """(P,) the cosine between the two triangles of quads (P, 4, 3) cut from corner 0 to 2; -0.5 where one is flat."""
    normals = triangle_normals(points[:, [[0, 1, 2], [0, 2, 3]]])
    sizes = np.linalg.norm(normals, axis=2)
    longest = ((points - np.roll(points, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
    flat = (sizes <= FLAT * longest[:, None]).any(axis=1)
    cosine = np.einsum("px,px->p", *normals.transpose(1, 0, 2)) / np.maximum(sizes.prod(axis=1), np.finfo(float).tiny)
    return np.where(flat, -0.5, cosine)


def _fans(vertices: np.ndarray, cut: np.ndarray) -> np.ndarray:
    """(P,) which fans (P, n − 2, 3) are right: their triangles go round the first corner, less than once, none flat."""
    a, b, c = vertices[cut].transpose(2, 0, 1, 3)
    normals = triangle_normals(vertices[cut])
    whole = normals.sum(axis=1, keepdims=True)
    whole = whole / np.maximum(np.linalg.norm(whole, axis=2, keepdims=True), np.finfo(float).tiny)
    up = (normals * whole).sum(axis=2)
    longest = np.maximum.reduce([((p - q) ** 2).sum(axis=2) for p, q in ((a, b), (b, c), (c, a))])
    angle = np.arctan2(np.linalg.norm(normals, axis=2), ((b - a) * (c - a)).sum(axis=2)).sum(axis=1)
    return (up > FLAT * longest).all(axis=1) & (angle < 2 * np.pi)


def ears(points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, "n-2 3"]:
    """(n − 2, 3) the triangles of a polygon (n, 3), the roundest ear first, seen along its mean normal.

    Raises:
        ValueError: it crosses itself.

    Reference:
        Meisters, "Polygons have ears", American Mathematical Monthly 82 (1975).
    """
    flat = _projected(points)
    left, found = list(range(len(points))), []
    worth: dict[int, float] = {}
    strict, fresh = True, True  # strict: no other corner on the border of an ear either
    while len(left) > 3:
        for place, corner in enumerate(left):
            if corner not in worth:
                worth[corner] = _ear(flat, left, place, strict)
        best = max(range(len(left)), key=lambda place: worth[left[place]])
        if worth[left[best]] <= FLAT and not (fresh and not strict):
            # Ears cut elsewhere may have freed this one; then corners on its border, and corners in line, are let be.
            strict, fresh, worth = strict and not fresh, True, {}
            continue
        if worth[left[best]] < 0:
            raise ValueError(CROSSED)
        before, after = left[best - 1], left[(best + 1) % len(left)]
        found.append((before, left[best], after))
        for corner in (before, left.pop(best), after):
            worth.pop(corner, None)
        fresh = False
    if _turn(*flat[left]) < -FLAT * np.ptp(flat, axis=0).max() ** 2:
        raise ValueError(CROSSED)
    return np.array([*found, tuple(left)])


def _ear(flat: np.ndarray, left: list[int], place: int, strict: bool) -> float:
    """How round the triangle at a corner is, 0 if it is flat, negative if it is no ear."""
    a, b, c = flat[[left[place - 1], left[place], left[(place + 1) % len(left)]]]
    longest = max(((p - q) ** 2).sum() for p, q in ((a, b), (b, c), (c, a)))
    round_ = _turn(a, b, c) / max(longest, np.finfo(float).tiny)
    if round_ <= FLAT:
        return round_ if round_ < -FLAT else 0.0
    rest = flat[left]
    rest = rest[~np.logical_or.reduce([(rest == corner).all(axis=1) for corner in (a, b, c)])]
    edge = FLAT * longest * (-1 if strict else 1)
    inside = (_turn(a, b, rest) > edge) & (_turn(b, c, rest) > edge) & (_turn(c, a, rest) > edge)
    return -1.0 if inside.any() else round_


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Twice the signed area of triangles in the plane."""
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])


def _projected(points: np.ndarray) -> np.ndarray:
    """(n, 2) a polygon (n, 3) along its mean normal (Newell's), counter-clockwise."""
    points = points - points.mean(axis=0)
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    size = np.linalg.norm(normal)
    if size <= FLAT * (np.ptp(points, axis=0) ** 2).sum():
        raise ValueError(CROSSED)
    normal = normal / size
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first = first / np.linalg.norm(first)
    return points @ np.stack([first, np.cross(normal, first)], axis=1)
