"""Girths cut from a scan at the heights where tapes lie on the mean person, as a scanner's software does."""

import numpy as np
from jaxtyping import Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from lssd_learn.collections.anthropometry.measures import NAMES
from lssd_learn.collections.anthropometry.sections import between
from lssd_learn.models.measuring import BodyReader
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.triangles import enclosed, triangle_normals

CUT = ("chest", "waist", "hip", "thigh", "calf", "neck")  # the others lie across arms


def read_by_sections(reader: BodyReader, mesh: Mesh, up: Float[np.ndarray, "3"]) -> Float[np.ndarray, " p"]:
    """(p,) measures of a scan in metres: its extent along `up`, which is told, the longest tape around its sections,
    area and volume; what is left is in the proportion to the height that the mean person has.

    For people who stand upright with their arms held off: others are measured so all the same.
    """
    weights = np.zeros(len(reader.figure.rest_modes))
    rest, marks = reader.figure.at_rest(weights)
    mean = dict(zip(NAMES, np.exp(reader.mean), strict=True))
    soles, along = rest[:, 2].min(), mesh.vertices @ up
    low, height = along.min(), np.ptp(along)
    found = {name: 1000 * height * mean[name] / mean["height_mm"] for name in NAMES}
    tapes = reader.figure.meter.girths(rest, marks)
    for part in CUT:
        name = f"{part}_girth_mm"
        level = (tapes[name].points[:, 2].mean() - soles) / np.ptp(rest[:, 2])
        found[name] = 1000 * _longest(mesh, along - low - level * height, up) or found[name]
    corners = mesh.vertices[mesh.faces]
    area = np.linalg.norm(triangle_normals(corners), axis=1).sum() / 2
    return np.array([*list(found.values())[:-2], area, 1000 * enclosed(corners)])


def _longest(mesh: Mesh, away: Float[np.ndarray, " V"], up: Float[np.ndarray, "3"]) -> float:
    """The longest tape around a piece of the section where `away` is zero; 0 where there is none."""
    first, second = mesh.faces, np.roll(mesh.faces, -1, axis=1)
    cut = (away[first] < 0) != (away[second] < 0)
    face = np.flatnonzero(cut.any(axis=1))
    if not len(face):
        return 0.0
    ends = np.sort(np.stack([first[face], second[face]], axis=2)[cut[face]], axis=1)  # two of each face
    every, place = np.unique(ends, axis=0, return_inverse=True)
    pairs = place.reshape(-1, 2)
    joined = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(every),) * 2)
    which = connected_components(joined, directed=False)[1]
    a, b = away[every].T
    points = between(mesh.vertices, every, a / (a - b))
    plane = points @ np.linalg.svd(up[None])[2][1:].T
    pieces = [plane[which == piece] for piece in range(which.max() + 1)]
    return max((float(ConvexHull(piece).area) for piece in pieces if len(piece) > 2), default=0.0)
