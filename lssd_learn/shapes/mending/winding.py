"""Faces that face the other way than their neighbours. Part of `clean`; no Laplacian depends on it, normals do."""

import numpy as np
from jaxtyping import Bool, Int

from lssd_learn.shapes.edges import groups


def turned(faces: Int[np.ndarray, "F 3"]) -> Bool[np.ndarray, " F"]:
    """(F,) which faces to turn over so that neighbours face the same way: in each piece the fewer.

    Neighbours share an edge that no third face has. A surface with one side only, such as a Möbius strip, stays.

    Args:
        faces: (F, 3), three different vertices each, no two with the same.
    """
    F, n = len(faces), faces.max() + 1
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    code, forward = np.minimum(start, end) * n + np.maximum(start, end), start < end
    order = np.argsort(code, kind="stable")
    _, first, count = np.unique(code[order], return_index=True, return_counts=True)
    one, other = order[first[count == 2]], order[first[count == 2] + 1]
    against = forward[one] == forward[other]  # neighbours that agree run through their edge in opposite directions
    if not against.any():
        return np.zeros(F, dtype=bool)
    # Each face is there twice, as it is (f) and turned (f + F): what belongs together is one way to face for a piece.
    f, g = one // 3, other // 3
    g = g + F * against
    label = groups(np.concatenate([np.stack([f, g], 1), np.stack([f + F, (g + F) % (2 * F)], 1)]), 2 * F)
    as_it_is, over = label[:F], label[F:]
    kept = np.bincount(as_it_is, minlength=label.max() + 1)  # so many faces stay as they are, if this way is chosen
    fewer = (kept[as_it_is] < kept[over]) | ((kept[as_it_is] == kept[over]) & (as_it_is > over))
    return fewer & (as_it_is != over)
