"""Named parts of a body, told from the bones its vertices follow. Used by `../bodies.py`."""

from collections.abc import Sequence

import numpy as np

# Beginnings of bone names; a limb's bones end in .L or .R.
_BONES = {
    "head": ("neck", "head", "eye", "jaw", "tongue"),
    "chest": ("spine", "clavicle", "shoulder", "breast"),
    "hip": ("root", "pelvis"),
    "arm": ("upperarm", "lowerarm", "wrist", "finger", "metacarpal"),
    "leg": ("upperleg", "lowerleg", "foot", "toe"),
}


def body_parts(bones: Sequence[str], weights: np.ndarray) -> dict[str, np.ndarray]:
    """Vertex masks of a body: head (with the neck), torso, left and right arm and leg, upper and lower body.

    Each vertex belongs to the part whose bones move it most. Head, torso, arms and legs cover the body without
    overlap, and so do upper and lower body, which part at the hips.

    Args:
        bones: B names.
        weights: (V, B) skinning weights.

    Returns:
        Name → (V,) bool.
    """
    kinds = [_kind(bone) for bone in bones]
    names = sorted(set(kinds))
    share = np.stack([weights[:, [kind == name for kind in kinds]].sum(1) for name in names], axis=1)
    strongest = np.array(names)[share.argmax(1)]
    part = {name: strongest == name for name in names}
    arms, legs = part["left_arm"] | part["right_arm"], part["left_leg"] | part["right_leg"]
    limbs = {name: part[name] for name in ("left_arm", "right_arm", "left_leg", "right_leg")}
    upper = part["head"] | part["chest"] | arms
    torso = part["chest"] | part["hip"]
    return {"head": part["head"], "torso": torso, **limbs, "upper_body": upper, "lower_body": part["hip"] | legs}


def half_of(bone: str) -> str:
    """The part a bone belongs to, "upper_body" or "lower_body"."""
    kind = _kind(bone)
    return "lower_body" if kind == "hip" or kind.endswith("leg") else "upper_body"


def _kind(bone: str) -> str:
    name = next(name for name, beginnings in _BONES.items() if bone.startswith(beginnings))
    side = {".L": "left_", ".R": "right_"}[bone[-2:]] if name in ("arm", "leg") else ""
    return side + name
