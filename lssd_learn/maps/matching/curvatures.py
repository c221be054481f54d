"""How a surface is curved, at several scales: what tells points apart that no eigenfunction does."""

import numpy as np
from scipy.sparse import csc_array, csr_array, dia_array
from scipy.sparse.linalg import splu

SCALES = np.geomspace(0.0005, 0.03, 6)  # times of heat flow at unit area: smoothed over .03 to .25 of √area


def curvatures(points: np.ndarray, normals: np.ndarray, stiffness: csr_array, mass: np.ndarray) -> np.ndarray:
    """(V, 12) mean curvature and flatness at six scales: neither a turn nor a bend elsewhere changes them.

    A step of heat flow of time t smooths coordinates x and normals n. Mean curvature is the way that x has gone along
    the smoothed normal, over √t; flatness the length of the smoothed normal, 1 where all around face one way.

    Args:
        points, normals: (V, 3), at unit area.
        stiffness: (V, V) of the Laplacian.
        mass: (V,).
    """
    found, weights = [], dia_array((mass[None], 0), shape=stiffness.shape)
    for t in SCALES:
        matrix = csc_array(weights + t * stiffness)
        solve = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve
        smooth, facing = np.hsplit(solve(mass[:, None] * np.hstack([points, normals])), 2)
        flatness = np.linalg.norm(facing, axis=1)
        along = np.einsum("vx,vx->v", smooth - points, facing) / np.maximum(flatness, np.finfo(float).tiny)
        found += [along / np.sqrt(t), flatness]
    return np.stack(found, axis=1)
