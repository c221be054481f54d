"""Two shapes matched as they lie: in any pose, however turned, without landmarks; and how far to trust the match.

The steps are in `matching/`; `computed.py` asks for `matched` pair by pair.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lssd_learn.errors import InputError
from lssd_learn.maps.matching.bending import Bent
from lssd_learn.maps.matching.candidates import ALL, candidates
from lssd_learn.maps.matching.measures import Measures, chosen
from lssd_learn.maps.matching.prepared import LEAST, Prepared, prepared
from lssd_learn.maps.matching.returned import middle, returned
from lssd_learn.shapes import Eigenbasis, Mesh, eigenbasis
from lssd_learn.shapes.kabsch import kabsch

FUNCTIONS = 80  # of an eigenbasis that has to be computed
MIRRORS = ("forbid", "allow")
DOUBTFUL = 0.8  # quality below which starts that looked hopeless are tried too: the right one may be among them
GAIN = 0.8  # a mirrored source is taken where its energy is below so much of the unmirrored one's


@dataclass(frozen=True, eq=False)
class Match:
    """Where each of the V_target vertices of the target lies on the source.

    Attributes:
        faces: (V_target,) faces of the source.
        barycentric: (V_target, 3) coordinates in them, not negative, of sum 1.
        corners: (V_target, 3) the vertices of these faces.
        quality: in [0, 1]: how likely the map is right, see `matching.measures.chosen`.
        rotation: (3, 3) R: the source, turned by it (x ↦ R x) after it was mirrored if it was, lies on the target best.
            Where the pose differs there is no more to it than that.
        mirrored: whether the source was mirrored (its x negated); the map then turns triangles over.
        measures: what the quality is made of.
    """

    faces: np.ndarray
    barycentric: np.ndarray
    corners: np.ndarray
    quality: float
    rotation: np.ndarray
    mirrored: bool
    measures: Measures

    @cached_property
    def vertices(self) -> np.ndarray:
        """(V_target,) for each vertex of the target the nearest corner of its face of the source."""
        return self.corners[np.arange(len(self.corners)), self.barycentric.argmax(axis=1)]

    def carried(self, values: np.ndarray) -> np.ndarray:
        """(V_target, …) values on the target, of values (V_source, …) at the vertices of the source."""
        return np.einsum("vc,vc...->v...", self.barycentric, np.asarray(values)[self.corners])

    def functional(self, source_basis: Eigenbasis, target_basis: Eigenbasis) -> np.ndarray:
        """C (k_target, k_source), which carries functions on the source to functions on the target.

        Raises:
            ValueError: bases of other shapes.
        """
        if len(self.vertices) != len(target_basis.mass):
            raise ValueError(f"expected a basis of {len(self.vertices)} vertices, got {len(target_basis.mass)}")
        return (target_basis.evecs * target_basis.mass[:, None]).T @ self.carried(source_basis.evecs)


@dataclass(frozen=True, eq=False)
class Found:
    """The best of the maps that were tried.

    Attributes:
        bent: the source, as it was bent, and the vertex maps.
        back: the target, bent back onto the source.
        measures, quality: of the first, see `matching.measures`.
    """

    bent: Bent
    back: Bent
    measures: Measures
    quality: float


def match(
    source_shape: Mesh,
    target_shape: Mesh,
    source_basis: Eigenbasis | None = None,
    target_basis: Eigenbasis | None = None,
    mirror: str = "forbid",
) -> Match:
    """Where each vertex of the target lies on the source.

    Neither pose nor place matters, nor how the shapes are turned. Left and right are told apart by the orientation of
    the triangles: of a shape with an inside it is the outward one that counts, whatever its faces say; those of open
    shapes face the same way on both.

    Args:
        source_shape, target_shape: meshes of one piece.
        source_basis, target_basis: their eigenbases; None, or fewer than 30 functions, computes 80.
        mirror: "forbid"; "allow" takes the source's mirror image where that fits clearly better, as with bones of the
            left and of the right. Bodies are their own mirror images, nearly: leave it forbidden.

    Raises:
        InputError: a cloud, another `mirror`, too few vertices; see also `eigenbasis`.
    """
    if mirror not in MIRRORS:
        raise InputError(f"mirror={mirror}: expected one of {', '.join(MIRRORS)}")
    source, target = ready(source_shape, source_basis), ready(target_shape, target_basis)
    found, mirrored = matched(source, target), False
    if mirror == "allow":
        image = prepared(_mirrored(source_shape), source.basis)
        other = matched(image, target)
        if other.measures.energy < GAIN * found.measures.energy:
            source, found, mirrored = image, other, True
    faces, weights = middle(source, target, found.bent, found.back)
    rotation = _rotation(source.points[found.bent.there], target.points, target.basis.mass)
    if (source.shape.faces[0] != source_shape.faces[0]).any():  # turned over, as a mirrored or inverted mesh is
        weights = weights[:, [0, 2, 1]]
    return Match(
        faces,
        weights,
        source_shape.faces[faces],
        found.quality,
        rotation,
        mirrored,
        found.measures,
    )


def matched(source: Prepared, target: Prepared) -> Found:
    """The best map between two shapes, both ways, by what can be seen of it without the truth."""
    best, seen, quality = chosen(source, candidates(source, target))
    if quality < DOUBTFUL:
        again = chosen(source, candidates(source, target, every=True, tried=ALL))
        if again[2] >= DOUBTFUL:  # where nothing fits, more starts do not help
            best, seen, quality = again
    return Found(best, returned(source, target, best), seen, quality)


def ready(shape: Mesh, basis: Eigenbasis | None = None) -> Prepared:
    """A mesh, prepared; where its eigenbasis is None or too small, with one of 80 functions.

    Raises:
        InputError: a cloud, or too few vertices.
    """
    if basis is None or basis.k < LEAST:
        basis = eigenbasis(shape, max(1, min(FUNCTIONS, len(shape.vertices) - 1)))
    return prepared(shape, basis)


def on_source(source: Prepared, target: Prepared, found: Found) -> tuple[np.ndarray, np.ndarray]:
    """(V_target, 3) vertices of the source and weights: for each vertex of the target its point of the source."""
    faces, weights = middle(source, target, found.bent, found.back)
    return source.shape.faces[faces], weights


def on_target(source: Prepared, target: Prepared, found: Found) -> tuple[np.ndarray, np.ndarray]:
    """The same the other way: (V_source, 3) vertices of the target and weights."""
    faces, weights = middle(target, source, found.back, found.bent)
    return target.shape.faces[faces], weights


def _mirrored(mesh: Mesh) -> Mesh:
    """Its image, x negated; faces keep their first corner and which way they face."""
    return Mesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, [0, 2, 1]])


def _rotation(points: np.ndarray, goals: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """(3, 3) the rotation that lays points (n, 3) on goals best, as it acts on columns."""
    points, goals = (places - mass @ places / mass.sum() for places in (points, goals))
    return kabsch(points, goals, mass).T
