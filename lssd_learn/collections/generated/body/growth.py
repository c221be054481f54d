"""Places of a body that can be made larger than the body model knows: a hand, a patch of the back.

In the rest pose points move away from the middle of the place, or from its axis, by a share that fades out at its
border; the pose carries what is moved along. Places of limbs are on the left.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.generated.body.model import BodyModel, body_model
from lssd_learn.shapes import Mesh


@dataclass(frozen=True)
class Place:
    """Where a body grows.

    Attributes:
        bones: beginnings of the names of the bones whose skin it is.
        side: end of their names, "" for bones in the middle.
        along: whether it grows about its long axis alone, as a neck that gets thicker.
        towards: of a patch in the middle of that skin its side, -1 the front and 1 the back; 0 is all of the skin.
        radius: of a patch, metres.
    """

    bones: tuple[str, ...]
    side: str = ""
    along: bool = False
    towards: int = 0
    radius: float = 0.0


PLACES = {
    "foot": Place(("foot", "toe"), ".L"),
    "neck": Place(("neck",), along=True),
    "forearm": Place(("lowerarm",), ".L", along=True),
    "hand": Place(("wrist", "finger", "metacarpal"), ".L"),
    "face": Place(("head",), towards=-1, radius=0.07),
    "back": Place(("spine", "clavicle"), towards=1, radius=0.12),
}


def grown_vertices(
    model: BodyModel, rest: Float[np.ndarray, "V 3"], place: str, share: float
) -> Float[np.ndarray, "V 3"]:
    """How far the vertices of a body in the rest pose move where a place grows.

    Args:
        model: of the body.
        rest: its vertices.
        place: one of `PLACES`.
        share: of the distance from the middle or the axis by which points move away, in the place itself.
    """
    where, weight = PLACES[place], weights(model, place)
    about = rest - weight @ rest / weight.sum()
    if where.along:
        axis = np.linalg.eigh((weight[:, None] * about).T @ about)[1][:, -1]
        about = about - np.outer(about @ axis, axis)
    return share * weight[:, None] * about


def weights(model: BodyModel, place: str) -> Float[np.ndarray, " V"]:
    """(V,) how much each vertex belongs to a place, at most 1."""
    where = PLACES[place]
    some = [bone.startswith(where.bones) and bone.endswith(where.side) for bone in model.bones]
    skin = model.bone_weights[:, some].sum(1)
    if where.towards:
        middle = model.vertices({}, "rest")
        centred = skin * np.exp(-np.square(middle[:, 0] / where.radius))
        centre = middle[np.where(centred > 0.5, where.towards * middle[:, 1], -np.inf).argmax()]
        skin = skin * np.exp(-np.square(middle - centre).sum(1) / (2 * where.radius**2))
    return skin / skin.max()


@cache
def share_of(topology: str, place: str, area: float) -> float:
    """The share at which the area of a place of the middle body in the rest pose grows by a part, as .1."""
    model = body_model(topology)
    rest, inner = model.vertices({}, "rest"), weights(model, place) > 0.5
    whole = Mesh(rest, model.faces).vertex_areas[inner].sum()

    def found(share: float) -> float:
        return Mesh(rest + grown_vertices(model, rest, place, share), model.faces).vertex_areas[inner].sum() / whole - 1

    low, high = (0.0, 4 * abs(area)) if area > 0 else (-1.0, 0.0)
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if found(middle) < area else (low, middle)
    return (low + high) / 2
