"""Last step of matching: the target bent back onto the source, and the middle of the two maps.

What is bent keeps something of its own shape, so that a map depends on which of the two it was, by .2 to .4 % of √area.
Where one group is listed before the other, all of one would be bent and none of the other: groups of the same bodies
would differ, significantly. The middle of both maps does not know who came first.
"""

import numpy as np

from lssd_learn.maps.matching.bending import Bent, bent, laid, roughly, told
from lssd_learn.maps.matching.features import features
from lssd_learn.maps.matching.lattice import lattices
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.matching.surface import near, on_faces

APART = 0.1  # √area: points farther apart than this have no middle, and the first map is taken


def returned(source: Prepared, target: Prepared, found: Bent) -> Bent:
    """The target bent onto the source, from where the source bent onto the target says that it lies."""
    rough = laid(target, source, found.back[source.samples], found.there[target.samples])
    nets, looks = lattices(target), features(target, source)
    for level in range(len(nets)):
        rough = roughly(nets, level, source, rough)
    return bent(target, source, looks, told(nets[-1], source, looks, rough))


def middle(source: Prepared, target: Prepared, there: Bent, back: Bent) -> tuple[np.ndarray, np.ndarray]:
    """(V_target,) faces of the source and (V_target, 3) weights: for each vertex of the target its point of the source.

    Args:
        source, target: the two shapes.
        there: the source, bent onto the target.
        back: the target, bent onto the source.
    """
    around = near(there.points, target.points, there.there)
    first, weights = on_faces(source.shape.faces, there.points, around, target.points)
    places = np.einsum("vc,vcx->vx", weights, source.points[source.shape.faces[first]])
    face, others = on_faces(source.shape.faces, source.points, near(source.points, back.points, back.back), back.points)
    seen = np.einsum("vc,vcx->vx", others, source.points[source.shape.faces[face]])
    together = np.linalg.norm(places - seen, axis=1, keepdims=True) <= APART
    halfway = np.where(together, (places + seen) / 2, places)
    return on_faces(source.shape.faces, source.points, near(source.points, halfway, there.there), halfway)
