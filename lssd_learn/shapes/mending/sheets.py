"""Faces that are given twice: with the same vertices, or as a sheet with two sides. Part of `clean`."""

import numpy as np
from jaxtyping import Bool, Float, Int

from lssd_learn.shapes.edges import border, pieces
from lssd_learn.shapes.mending.places import places


def first_of_each(faces: Int[np.ndarray, "F 3"]) -> Bool[np.ndarray, " F"]:
    """(F,) which faces are the first with their three vertices, whatever the order of these."""
    _, first = _kinds(faces)
    is_first = np.zeros(len(faces), dtype=bool)
    is_first[first] = True
    return is_first


def one_side(vertices: Float[np.ndarray, "V 3"], faces: Int[np.ndarray, "F 3"]) -> Bool[np.ndarray, " F"]:
    """(F,) which faces stay if of each two-sided sheet, or piece that is there twice, one does.

    Its sides have vertices of their own, at the same places. A piece goes only if each of its faces is there once
    more, and it is open or lies on one other piece: where two bodies touch, as cells do in a tissue, both are needed.

    Args:
        vertices: (V, 3).
        faces: (F, 3), no two with the same vertices.
    """
    used = np.unique(faces)
    place = np.zeros(len(vertices), dtype=np.int64)
    place[used] = places(vertices, faces, used)
    kind, first = _kinds(place[faces])
    stays = np.ones(len(faces), dtype=bool)
    if len(first) == len(faces):
        return stays
    count, piece = pieces(faces, len(vertices))
    open_piece = np.zeros(count, dtype=bool)
    open_piece[piece[border(faces)[:, 0]]] = True
    piece = piece[faces[:, 0]]
    whole = np.bincount(piece[np.bincount(kind)[kind] == 1], minlength=count) == 0  # each face is there once more
    # Of a kind stays the first, if possible the first in a piece that is not there twice.
    order = np.lexsort([np.arange(len(faces)), whole[piece], kind])
    best = order[np.unique(kind[order], return_index=True)[1]][kind]
    goes = whole[piece] & (best != np.arange(len(faces)))
    lowest, highest = np.full(count, count), np.full(count, -1)
    np.minimum.at(lowest, piece[goes], piece[best[goes]])
    np.maximum.at(highest, piece[goes], piece[best[goes]])
    return ~(goes & (open_piece | (lowest == highest))[piece])


def _kinds(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(F,) equal numbers for faces with the same corners, in any order, and the first face of each number."""
    _, first, kind = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_inverse=True)
    return kind.ravel(), first
