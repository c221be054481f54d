"""The functional map of a vertex correspondence."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.shapes import Eigenbasis


def from_correspondence(
    source: Eigenbasis, target: Eigenbasis, vertices: Int[np.ndarray, " V_target"] | None = None
) -> Float[np.ndarray, "k_target k_source"]:
    """C (k_target, k_source), which carries functions on `source` to functions on `target`: C = Φₜᵀ Mₜ Π Φₛ.

    The masses make it the best approximation in the norm of the target: the unweighted least-squares variant differs
    by several percent in C.

    Args:
        source, target: eigenbases of V_source and V_target vertices.
        vertices: (V_target,) for each vertex of the target the vertex of the source; None is vertex identity.

    Raises:
        ValueError: `vertices` has the wrong length, or is None though the two connectivities differ.
    """
    if vertices is None:
        if len(source.mass) != len(target.mass) or source.connectivity != target.connectivity:
            raise ValueError("vertex identity needs two shapes of one connectivity; give the vertices")
        carried = source.evecs
    elif len(vertices) != len(target.mass):
        raise ValueError(
            f"vertices: expected one for each of the {len(target.mass)} target vertices, got {len(vertices)}"
        )
    else:
        carried = source.evecs[vertices]
    return (target.evecs * target.mass[:, None].astype(target.evecs.dtype)).T @ carried


def from_points(
    source: Eigenbasis,
    target: Eigenbasis,
    corners: Int[np.ndarray, "V_target 3"],
    weights: Float[np.ndarray, "V_target 3"],
) -> Float[np.ndarray, "k_target k_source"]:
    """The same of points inside triangles.

    Args:
        source, target: eigenbases of V_source and V_target vertices.
        corners, weights: for each vertex of the target three vertices of the source, and its place among them.
    """
    carried = np.einsum("vc,vck->vk", weights, source.evecs[corners])
    return (target.evecs * target.mass[:, None]).T @ carried
