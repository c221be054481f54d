"""First step of matching: what is known of one shape by itself, made once however many pairs it takes part in."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lssd_learn.errors import InputError
from lssd_learn.maps.matching.curvatures import curvatures
from lssd_learn.shapes import Eigenbasis, Mesh, laplacian
from lssd_learn.shapes.descriptors import at_unit_area
from lssd_learn.shapes.geodesics import graph
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.sampling import farthest_points

SAMPLES = 1000  # spread points that the map is found on before all vertices are matched
ENDS = 7  # of limbs and the like: points that stick out
MAIN = 4  # of these, the ones that stick out most
FUNCTIONS = 60  # that descriptors and ends are made of
FLAT = 0.02  # three times the volume at unit area that a shape has an inside from: a sphere's is .28, a body's .09
LEAST = 30  # functions below which nothing is found


@dataclass(frozen=True, eq=False)
class Prepared:
    """A mesh at unit area, its centre of mass at the origin.

    Attributes:
        shape: the mesh as it lies, its faces turned over where they point inward.
        basis: at unit area.
        points, normals: (V, 3).
        stiffness: (V, V) of its Laplacian.
        graph: (V, V) of lengths, see `geodesics.graph`.
        embedding: (V, k) its eigenfunctions in single precision.
        samples: (n,) vertices, spread out, the farthest first.
        ends: (m,) vertices that stick out, see `_ends`.
        paths: (m, V) lengths of shortest paths from the ends, over the mean length among the first four: who is long
            in the limb, or bent so that skin is stretched, is so all over.
        reach: (V,) how far a point is from the rest: the logarithm of its squared distance from the centre of the
            biharmonic embedding.
        curvatures: (V, e) see `curvatures`.
    """

    shape: Mesh
    basis: Eigenbasis
    points: np.ndarray
    normals: np.ndarray
    stiffness: csr_array
    graph: csr_array
    embedding: np.ndarray
    samples: np.ndarray
    ends: np.ndarray
    paths: np.ndarray
    reach: np.ndarray
    curvatures: np.ndarray


def prepared(shape: Mesh, basis: Eigenbasis) -> Prepared:
    """What is known of a mesh before it is matched with another.

    Args:
        shape: V vertices, one piece, faces oriented alike.
        basis: its eigenfunctions.

    Raises:
        InputError: a cloud, or fewer than 30 eigenfunctions.
    """
    if not isinstance(shape, Mesh):
        raise InputError("match: expected meshes, whose triangles tell left from right, got a cloud")
    if basis.k < LEAST:
        raise InputError(f"match: expected {LEAST} eigenfunctions or more, got {basis.k}")
    unit, size = at_unit_area(basis), np.sqrt(basis.area)
    points = shape.vertices / size
    points, facing = points - unit.mass @ points, normals(shape)
    if unit.mass @ np.einsum("vx,vx->v", points, facing) < -FLAT:  # inside out
        shape, facing = Mesh(shape.vertices, shape.faces[:, [0, 2, 1]]), -facing
    (ends, reach), on, stiffness = _ends(unit), graph(shape), laplacian(shape)[0]
    return Prepared(
        shape,
        unit,
        points,
        facing,
        stiffness,
        on,
        unit.evecs.astype(np.float32),
        farthest_points(points, min(SAMPLES, len(points))),
        ends,
        _paths(on, ends),
        reach,
        curvatures(points, facing, stiffness, unit.mass),
    )


def _paths(on: csr_array, ends: np.ndarray) -> np.ndarray:
    """Paths of `Prepared`, in a graph."""
    lengths = dijkstra(on, directed=False, indices=ends)
    first, second = np.triu_indices(MAIN, 1)
    return lengths / lengths[first, ends[second]].mean()


def _ends(basis: Eigenbasis) -> tuple[np.ndarray, np.ndarray]:
    """Ends and reach of `Prepared`: points each the farthest from those before it, in the biharmonic distance.

    Reference:
        Lipman, Rustamov and Funkhouser, "Biharmonic distance", ACM Transactions on Graphics 29 (2010).
    """
    place = basis.evecs[:, 1:FUNCTIONS] / basis.evals[1:FUNCTIONS]
    squares = (place**2).sum(axis=1)
    ends = [int(squares.argmax())]
    near = ((place - place[ends[0]]) ** 2).sum(axis=1)
    while len(ends) < ENDS:
        ends.append(int(near.argmax()))
        near = np.minimum(near, ((place - place[ends[-1]]) ** 2).sum(axis=1))
    return np.array(ends), np.log(np.maximum(squares, np.finfo(float).tiny))
