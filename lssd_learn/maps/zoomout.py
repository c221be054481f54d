"""ZoomOut: a coarse map becomes a fine one by going to vertices and back with more and more functions."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import InputError
from lssd_learn.maps.conversion import to_vertices
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.shapes import Eigenbasis


def zoomout(
    source: Eigenbasis, target: Eigenbasis, start: np.ndarray, k_final: int | None = None, step: int = 5, k: int = 20
) -> Float[np.ndarray, "k_final k_final"]:
    """C (k_final, k_final), refined from a smaller map that carries functions on `source` to functions on `target`.

    Again and again the map is turned into vertices, and these into the map of `step` more functions. Where shapes are
    not isometric, high frequencies are matched to the wrong ones and spoil the rest: k_final well below all functions
    is wise.

    Args:
        source, target: eigenbases.
        start: C (l, m), of the first m functions of the source and the first l of the target; or a vertex map
            (V_target,), for each vertex of the target the vertex of the source.
        k_final: functions in the end; None is all that both bases have.
        step: functions more a round.
        k: functions that a vertex map starts with.

    Raises:
        InputError: k_final out of range, step or k below 1.

    Reference:
        Melzi, Ren, Rodolà, Sharma, Wonka and Ovsjanikov, "ZoomOut: spectral upsampling for efficient shape
        correspondence", ACM Transactions on Graphics 38 (2019).
    """
    most = min(source.k, target.k)
    k_final = most if k_final is None else k_final
    if not 1 <= k_final <= most or step < 1 or k < 1:
        raise InputError(f"zoomout: expected 1 to {most} functions, step and k 1 or more, got {k_final}, {step}, {k}")
    C = np.asarray(start)
    if C.ndim == 1:
        small = min(k, k_final)
        C = from_correspondence(source.truncate(small), target.truncate(small), C)
    C = C[:k_final, :k_final]
    for size in (*range(max(C.shape) + step, k_final, step), k_final):
        C = from_correspondence(source.truncate(size), target.truncate(size), to_vertices(source, target, C))
    return C


def zoomed_vertices(
    source: Eigenbasis, target: Eigenbasis, C: Float[np.ndarray, "l m"], refined: int | None
) -> Int[np.ndarray, " V_target"]:
    """(V_target,) the vertex map of C after ZoomOut to `refined` functions, all if there are fewer; None: without."""
    if refined is not None:
        C = zoomout(source, target, C, min(refined, source.k, target.k))
    return to_vertices(source, target, C)
