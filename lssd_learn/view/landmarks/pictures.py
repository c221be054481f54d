"""Landmarks as balls on their shapes: close up from outside, and all of a shape at once."""

from collections.abc import Sequence

import numpy as np
import trimesh
from jaxtyping import Float

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import nearest_orthogonal
from lssd_learn.shapes.normals import normals
from lssd_learn.view.painter import paint

COLOURS = "coolwarm"  # bone in its pale middle, a landmark at the blue end, one to be checked at the red end
BONE, PLAIN, CHECK = 0.0, -1.0, 1.0
BALL = 0.012  # radius, over √area
NEAR = 0.22  # radius of what a close picture shows, over √area


def with_balls(
    shape: Mesh, points: Float[np.ndarray, "m 3"], values: Sequence[float], radius: float = BALL
) -> tuple[Mesh, np.ndarray]:
    """A mesh with a ball at each of m points, and (V + 42 m,) values: those of the balls, and of the shape itself.

    Args:
        shape: V vertices.
        points: in its units.
        values: of the balls, such as `PLAIN`.
        radius: over √area.
    """
    ball = trimesh.creation.icosphere(subdivisions=1)
    size, count = radius * np.sqrt(shape.area), len(ball.vertices)
    vertices = [shape.vertices, *(point + size * ball.vertices for point in points)]
    starts = len(shape.vertices) + count * np.arange(len(points))
    faces = [shape.faces, *(ball.faces + start for start in starts)]
    painted = np.concatenate([np.full(len(shape.vertices), BONE), np.repeat(np.asarray(values, dtype=float), count)])
    return Mesh(np.concatenate(vertices), np.concatenate(faces)), painted


def close_up(
    shape: Mesh, points: Float[np.ndarray, "L 3"], number: int, view: Float[np.ndarray, "3 3"], size: int = 220
) -> np.ndarray:
    """(H, W, 3) uint8: the surface around one landmark, which is red, with those of the others that are near.

    Args:
        shape: a mesh.
        points: its landmarks, NaN for those that are not there.
        number: of the one.
        view: rows to the right, up and towards the viewer.
        size: in pixels.
    """
    reach, middle = NEAR * np.sqrt(shape.area), points[number]
    away = np.linalg.norm(shape.vertices - middle, axis=1)
    reach = max(reach, 1.5 * away.min())
    faces = shape.faces[(away[shape.faces] < reach).all(axis=1)]
    kept, renamed = np.unique(faces, return_inverse=True)
    part = Mesh((shape.vertices[kept] - middle) @ view.T, renamed.reshape(-1, 3))
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(np.linalg.norm(points - middle, axis=1) < reach)
    values = [CHECK if other == number else PLAIN for other in near]
    scene, painted = with_balls(part, (points[near] - middle) @ view.T, values, BALL * np.sqrt(shape.area / part.area))
    # Two specks keep the picture about the landmark, whatever the patch.
    corners = reach * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, -1.0]])
    specks = [corner + 1e-6 * reach * np.eye(3) for corner in corners]
    vertices = np.concatenate([scene.vertices, *specks])
    extra = len(scene.vertices) + np.arange(6).reshape(2, 3)
    framed = Mesh(vertices, np.concatenate([scene.faces, extra]))
    return _painted(framed, np.concatenate([painted, np.zeros(6)]), size)


def whole(
    shape: Mesh,
    points: Float[np.ndarray, "L 3"],
    values: Sequence[float],
    view: Float[np.ndarray, "3 3"],
    size: int = 220,
) -> np.ndarray:
    """(H, W, 3) uint8: a shape with all its landmarks, of these values; arguments as of `close_up`."""
    here = np.isfinite(points.sum(axis=1))
    turned = Mesh(shape.vertices @ view.T, shape.faces)
    some = [value for value, known in zip(values, here, strict=True) if known]
    return _painted(*with_balls(turned, points[here] @ view.T, some, 1.5 * BALL), size)


def view_of(shape: Mesh, point: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """Rows to the right, up and towards a viewer who looks at a landmark from outside; the shape's long axis is up."""
    size = 0.03 * np.sqrt(shape.area)
    around = np.linalg.norm(shape.vertices - point, axis=1)
    near = around < max(size, around.min() * 1.2)
    towards = normals(shape)[near].sum(axis=0)
    centred = shape.vertices - shape.vertices.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1].T
    towards = towards / np.linalg.norm(towards) if np.linalg.norm(towards) > 0 else axes[2]
    # Along the long axis, unless one looks along it.
    up = axes[0] if abs(axes[0] @ towards) < 0.9 else axes[1]
    up = up - (up @ towards) * towards
    up /= np.linalg.norm(up)
    return np.stack([np.cross(up, towards), up, towards])


def turned_like(
    view: Float[np.ndarray, "3 3"],
    shape: Mesh,
    points: Float[np.ndarray, "L 3"],
    other: Mesh,
    others: Float[np.ndarray, "L 3"],
) -> Float[np.ndarray, "3 3"]:
    """A view of `shape` in which it lies as `other` does in its own; mirrored where the one is the other's image.

    Args:
        view: of `other`.
        points, others: landmarks of both, of which they are told; with fewer than four in common, the nearest
            vertices' normals stand in.
    """
    both = np.isfinite((points + others).sum(axis=1))
    a, b = (
        np.concatenate([marks[both], _above(mesh, marks[both])]) for mesh, marks in ((shape, points), (other, others))
    )
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return view @ nearest_orthogonal(a.T @ b).T


def _above(mesh: Mesh, marks: np.ndarray) -> np.ndarray:
    """(m, 3) points above landmarks: a tenth of the shape's size along its normals there."""
    nearest = cKDTree(mesh.vertices).query(marks)[1]
    return marks + 0.1 * np.sqrt(mesh.area) * normals(mesh)[nearest]


def _painted(mesh: Mesh, values: np.ndarray, size: int) -> np.ndarray:
    return paint(mesh, values, size=size, azimuth=0, elevation=0, up="y", colormap=COLOURS, limits=(PLAIN, CHECK))
