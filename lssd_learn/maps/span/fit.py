"""Second step: the mixture of known shapes that lies on a new one.

Bending lets points slide along a surface, unseen. A mixture cannot: where it lies on the surface all over, each of its
points is where that point of the known shapes is.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.span.span import Span
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.normals import normals

ROUNDS, FIRST = 10, 5
POINTS = 3000  # vertices of a mixture that are matched in a round
ROUGH = 0.01**2 / 300  # mean square error of where points are taken to lie at first, over area and how many tell
CLOSE = 0.003**2 / 3000  # the same of where the surface is
FAR = 0.02  # over √area: what is so far from the surface counts half
NORMALS = 0.05  # weight of a unit normal against a distance of √area


@dataclass(frozen=True, eq=False)
class Surface:
    """A new shape at unit area.

    Attributes:
        points: (V, 3).
        normals: (V, 3) unit; None of a cloud.
    """

    points: Float[np.ndarray, "V 3"]
    normals: Float[np.ndarray, "V 3"] | None


def fitted(of: Span, mesh: Mesh, places: Float[np.ndarray, "V 3"], onto: Surface) -> Float[np.ndarray, "V 3"]:
    """(V, 3) the points of the mixture, turned and shifted, that lies on a surface, beginning from where points lie.

    Each round matches some of its vertices with the nearest points of the surface, in place and normal, and takes a
    step of Gauss and Newton's towards their tangent planes. Likely mixtures are preferred a little, and what is far off
    counts for less.

    Args:
        of: what known shapes span, at unit area of the new one.
        mesh: one of them, for its faces.
        places: about where their vertices lie on the surface.
        onto: the surface.

    Reference:
        Planes of the matched points after Chen and Medioni, "Object modelling by registration of multiple range
        images", Image and Vision Computing 10 (1992).
    """
    some = np.unique(np.linspace(0, len(places) - 1, min(POINTS, len(places))).astype(int))
    mass, modes = of.mass[some] / of.mass[some].sum(), of.modes[:, some]
    weights, turn, shift = _begun(of, places)
    prior = CLOSE / of.deviations**2
    marks = None if onto.normals is None else NORMALS * onto.normals
    tree = cKDTree(onto.points if marks is None else np.hstack([onto.points, marks]))
    for _ in range(ROUNDS):
        points = of.at(weights) @ turn + shift
        facing, at = normals(mesh, points)[some], points[some]
        found = tree.query(at if marks is None else np.hstack([at, NORMALS * facing]))[1]
        planes = facing if onto.normals is None else onto.normals[found]
        off = ((onto.points[found] - at) * planes).sum(axis=1)
        share = mass / (1 + (off / FAR) ** 2)
        along = np.einsum("rvx,xy,vy->vr", modes, turn, planes)
        rows = np.hstack([np.cross(at, planes), planes, along])
        left, right = rows.T @ (rows * share[:, None]), rows.T @ (share * off)
        right[6:] -= prior * weights
        left[np.diag_indices_from(left)] += np.concatenate([np.full(6, 1e-12 * np.trace(left)), prior])
        step = np.linalg.solve(left, right)
        more = Rotation.from_rotvec(step[:3]).as_matrix().T
        turn, shift, weights = turn @ more, shift @ more + step[3:6], weights + step[6:]
    return of.at(weights) @ turn + shift


def _begun(of: Span, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights, rotation and shift of the mixture nearest to places, the likelier the better."""
    weights, middle = np.zeros(len(of.deviations)), of.mass @ places
    for _ in range(FIRST):
        turn = kabsch(of.at(weights), places - middle, of.mass)
        off = (places - middle) @ turn.T - of.mean
        weights = np.einsum("rvx,v,vx->r", of.modes, of.mass, off) / (1 + ROUGH / of.deviations**2)
    return weights, turn, middle
