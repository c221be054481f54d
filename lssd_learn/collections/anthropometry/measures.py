"""What a tape measure, a stadiometer and a calliper say of a generated body as it stands in the rest pose.

Body dimensions in the sense of ISO 8559-1:2017, as far as a surface that does not breathe has them: a girth is what a
tape measures, which lies in a plane and spans hollows, at a level that landmarks of the body say. Landmarks are
vertices of the full body (topology "notoes") and heads of bones. A dimension is of the person, not of the pose.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.collections.anthropometry.sections import loop_length, section, tape
from lssd_learn.shapes.edges import edges
from lssd_learn.shapes.triangles import enclosed, triangle_normals

TOPOLOGY = "notoes"  # the body that is measured, whatever the topology of a collection is
VERSION = 1  # goes up whenever the same body has other measures

# Vertices of that topology.
CROTCH = 4372  # the lowest of the midline between the legs
CERVICALE = 858  # on the midline of the nape, at the height of the lowest bone of the neck
ACROMION, ACROMION_RIGHT = 7682, 1558  # on top of the shoulder, over the joint
NIPPLE = 8000  # the foremost of the left breast
BUTTOCK = 10300  # the hindmost of the left buttock
# Around the body in this order: the loop of anny's `anthropometry.py`, which numbers vertices otherwise.
WAIST = np.array([
    4121, 10209, 10206, 10203, 10223, 10222, 10225, 10226, 10224, 10227, 10217, 10219, 10218, 10221, 10220, 10260,
    10280, 10262, 10263, 10264, 10265, 10266, 10267, 4181, 4180, 4179, 4178, 4177, 4176, 4175, 4196, 4173, 4131, 4132,
    4129, 4130, 4128, 4138, 4135, 4137, 4136, 4133, 4134, 4108, 4113, 4118,
])  # fmt: skip

# The calf is measured where it is thickest: at so many levels between these parts of the way from knee to ankle.
CALF_LEVELS = np.linspace(0.1, 0.5, 17)
THIGH_LEVEL = 0.1  # of the way from crotch to knee, under the fold of the buttock


@dataclass(frozen=True)
class Measure:
    """One dimension: its name as a column has it, which ends in its unit, and what is measured."""

    name: str
    means: str

    @property
    def unit(self) -> str:
        return {"m2": "m²", "l": "l"}.get(self.name.rpartition("_")[2], "mm")

    @property
    def title(self) -> str:
        return self.name.rpartition("_")[0].replace("_", " ")


MEASURES = (
    Measure("height_mm", "crown to soles, upright"),
    Measure("chest_girth_mm", "horizontal tape at the level of the nipples, arms left out"),
    Measure("waist_girth_mm", "the loop of vertices that the body model itself calls waist"),
    Measure("hip_girth_mm", "horizontal tape at the level where the buttocks reach farthest back"),
    Measure("thigh_girth_mm", "horizontal tape around the left thigh, a tenth of the way from crotch to knee"),
    Measure("calf_girth_mm", "horizontal tape around the left calf where it is thickest"),
    Measure("upper_arm_girth_mm", "tape across the left upper arm, midway between acromion and elbow"),
    Measure("neck_girth_mm", "tape across the neck, midway between its lowest bone and the head's"),
    Measure("wrist_girth_mm", "tape across the left lower arm at the wrist"),
    Measure("inside_leg_mm", "crotch to soles, upright"),
    Measure("arm_length_mm", "left acromion over elbow to wrist"),
    Measure("shoulder_breadth_mm", "between the acromia"),
    Measure("torso_length_mm", "vertical from cervicale to crotch"),
    Measure("area_m2", "of the skin"),
    Measure("volume_l", "enclosed by the skin"),
)
NAMES = tuple(measure.name for measure in MEASURES)


# The part of the body that the tape of each girth goes around, see `tape_parts`.
PART = {
    "chest_girth_mm": "torso",
    "waist_girth_mm": "torso",
    "hip_girth_mm": "trunk",
    "thigh_girth_mm": "thigh",
    "calf_girth_mm": "leg",
    "upper_arm_girth_mm": "arm",
    "neck_girth_mm": "neck",
    "wrist_girth_mm": "arm",
}


@dataclass(frozen=True)
class Tape:
    """A girth: the length in the unit of the body, and (h, 3) the points of the body that the tape lies on."""

    length: float
    points: Float[np.ndarray, "h 3"]


class Anthropometer:
    """Measures bodies of the topology `TOPOLOGY`.

    Args:
        faces: (F, 3) of that topology.
        parts: name → (V,) masks, see `tape_parts`.
    """

    def __init__(self, faces: Int[np.ndarray, "F 3"], parts: Mapping[str, np.ndarray]):
        self._faces = faces
        self._edges = {name: edges_within(faces, mask) for name, mask in parts.items()}

    def girths(
        self, vertices: Float[np.ndarray, "V 3"], joints: Mapping[str, Float[np.ndarray, "3"]]
    ) -> dict[str, Tape]:
        """Name of each girth → the tape on a body in the rest pose, in metres, z up.

        Args:
            vertices: (V, 3).
            joints: bone → (3,) its head.
        """
        knee, ankle, elbow = joints["lowerleg01.L"], joints["foot.L"], joints["lowerarm01.L"]
        crotch, neck, head = vertices[CROTCH], joints["neck01"], joints["head"]
        up = np.array([0.0, 0.0, 1.0])

        def around(name: str, point: np.ndarray, normal: np.ndarray = up) -> Tape:
            return Tape(*tape(section(vertices, self._edges[PART[f"{name}_girth_mm"]], point, normal), normal))

        calf = [around("calf", knee + share * (ankle - knee)) for share in CALF_LEVELS]
        return {
            "chest_girth_mm": around("chest", vertices[NIPPLE]),
            "waist_girth_mm": Tape(loop_length(vertices[WAIST]), vertices[WAIST]),
            "hip_girth_mm": around("hip", vertices[BUTTOCK]),
            "thigh_girth_mm": around("thigh", crotch + THIGH_LEVEL * (knee - crotch)),
            "calf_girth_mm": max(calf, key=lambda tape: tape.length),
            "upper_arm_girth_mm": around("upper_arm", (vertices[ACROMION] + elbow) / 2, elbow - joints["upperarm01.L"]),
            "neck_girth_mm": around("neck", (neck + head) / 2, head - neck),
            "wrist_girth_mm": around("wrist", joints["wrist.L"], joints["wrist.L"] - joints["lowerarm02.L"]),
        }

    def measure(
        self, vertices: Float[np.ndarray, "V 3"], joints: Mapping[str, Float[np.ndarray, "3"]]
    ) -> Float[np.ndarray, " p"]:
        """(p,) the `MEASURES` of a body in the rest pose, in their units; arguments as of `girths`."""
        corners = vertices[self._faces]
        low, high = vertices[:, 2].min(), vertices[:, 2].max()
        shoulder, elbow, wrist = vertices[ACROMION], joints["lowerarm01.L"], joints["wrist.L"]
        metres = {
            "height_mm": high - low,
            **{name: tape.length for name, tape in self.girths(vertices, joints).items()},
            "inside_leg_mm": vertices[CROTCH, 2] - low,
            "arm_length_mm": np.linalg.norm(elbow - shoulder) + np.linalg.norm(wrist - elbow),
            "shoulder_breadth_mm": np.linalg.norm(shoulder - vertices[ACROMION_RIGHT]),
            "torso_length_mm": vertices[CERVICALE, 2] - vertices[CROTCH, 2],
        }
        found = {name: 1000 * length for name, length in metres.items()}
        return np.array(
            [*found.values(), np.linalg.norm(triangle_normals(corners), axis=1).sum() / 2, 1000 * enclosed(corners)]
        )


def tape_parts(parts: Mapping[str, np.ndarray], left: np.ndarray) -> dict[str, np.ndarray]:
    """Name → (V,) masks of what tapes go around, from those of `body_parts` and that of the left half of the body."""
    trunk = parts["torso"] | parts["left_leg"] | parts["right_leg"]
    return {
        "torso": parts["torso"],
        "trunk": trunk,
        "thigh": trunk & left,
        "leg": parts["left_leg"],
        "arm": parts["left_arm"],
        "neck": parts["head"] | parts["torso"],
    }


def edges_within(faces: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """(E, 2) the edges of which both ends are in a mask (V,)."""
    every = edges(faces)
    return every[mask[every].all(1)]
