"""The Laplacian of a shape: stiffness L and lumped mass M, from which `eigenbasis` takes the eigenfunctions.

L is positive semi-definite everywhere in this package; the Laplace–Beltrami operator is M⁻¹L, in 1 / (unit of length)².
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np
import robust_laplacian
from jaxtyping import Float
from scipy.sparse import csr_array

from lssd_learn.errors import InputError
from lssd_learn.shapes.clean import is_fit_for_cotangent
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape

S = TypeVar("S", Mesh, PointCloud)

KINDS = ("auto", "cotangent", "robust")
NEIGHBOURS = 30  # of a point in the local triangulation of a cloud, robust_laplacian's own choice


def laplacian(shape: Shape, kind: str = "auto") -> tuple[csr_array, Float[np.ndarray, " V"]]:
    """Stiffness L (V, V), sparse, and masses M (V,), of `shape`.

    Args:
        shape: a mesh or a cloud.
        kind: `cotangent`, `robust`, or `auto`: cotangent for a mesh that is fit for it, otherwise robust.

    Raises:
        InputError: an unknown kind, `cotangent` for a cloud or a mesh with zero-area faces, a cloud of too few points.
    """
    if kind not in KINDS:
        raise InputError(f"laplacian: expected one of {' '.join(KINDS)}, got {kind!r}")
    if kind == "auto":
        kind = "cotangent" if isinstance(shape, Mesh) and is_fit_for_cotangent(shape) else "robust"
    if kind == "robust":
        return robust(shape)
    if isinstance(shape, PointCloud):
        raise InputError("laplacian: cotangent needs a mesh, a point cloud needs robust or auto")
    return cotangent(shape)


def cotangent(mesh: Mesh) -> tuple[csr_array, Float[np.ndarray, " V"]]:
    """The cotangent stiffness and barycentric masses of a mesh, those of linear finite elements with lumped mass.

    L_ij = −(cot α + cot β) / 2 with α, β the angles opposite to edge ij; M_i = a third of the area around vertex i.

    Raises:
        InputError: a zero-area face.

    Reference:
        Pinkall and Polthier, "Computing discrete minimal surfaces and their conjugates", Experimental
        Mathematics 2 (1993).
    """
    areas, n = mesh.face_areas, len(mesh.vertices)
    if not areas.all():
        raise InputError(
            f"laplacian: cotangent needs faces with an area, {(areas == 0).sum():,} of {len(areas):,} have none; "
            "robust accepts them"
        )
    corners = mesh.vertices[mesh.faces]
    edges = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)  # edge c lies opposite to corner c
    # The angle at corner c lies between the other two edges, both pointing the same way round.
    cotangents = -np.einsum("fcx,fcx->fc", np.roll(edges, -1, axis=1), np.roll(edges, 1, axis=1)) / (2 * areas[:, None])
    start, end = mesh.faces[:, [1, 2, 0]].ravel(), mesh.faces[:, [2, 0, 1]].ravel()
    upper = csr_array((cotangents.ravel() / 2, (start, end)), shape=(n, n))
    weights = upper + upper.T
    diagonal = csr_array((weights.sum(axis=1), (np.arange(n), np.arange(n))), shape=(n, n))
    return diagonal - weights, mesh.vertex_areas


def robust(shape: Shape) -> tuple[csr_array, Float[np.ndarray, " V"]]:
    """The Laplacian of any mesh or cloud: on an intrinsic Delaunay triangulation of the tufted cover.

    Raises:
        InputError: a cloud of too few points.

    Reference:
        Sharp and Crane, "A Laplacian for nonmanifold triangle meshes", Computer Graphics Forum 39 (2020).
    """
    points = shape.vertices - shape.vertices.mean(axis=0)  # for a cloud its answer depends on the origin, by per cents
    if isinstance(shape, Mesh):
        L, M = robust_laplacian.mesh_laplacian(points, shape.faces)
    else:
        if len(points) <= NEIGHBOURS:
            raise InputError(f"laplacian: a point cloud needs more than {NEIGHBOURS} points, got {len(points)}")
        L, M = robust_laplacian.point_cloud_laplacian(points, n_neighbors=NEIGHBOURS)
    return csr_array(L), M.diagonal()


def normalised_area(shape: S) -> S:
    """`shape` scaled about the origin to unit area; a cloud's area is the sum of its robust masses."""
    area = shape.area if isinstance(shape, Mesh) else robust(shape)[1].sum()
    if isinstance(shape, PointCloud):
        return PointCloud(shape.points / np.sqrt(area))
    return replace(shape, vertices=shape.vertices / np.sqrt(area))
