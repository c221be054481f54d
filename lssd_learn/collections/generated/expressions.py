"""The expressions the generated faces wear: plain data. `faces.py` gives them to identities.

Each is a set of anny's facial actions, named and meant as those of ARKit, with how far each goes: 0 not at all, 1 as
far as it can. A name without Left or Right stands for both sides.
"""

EXPRESSIONS: dict[str, dict[str, float]] = {
    "neutral": {},
    "happy": {"mouthSmile": 1.0, "cheekSquint": 0.7, "eyeSquint": 0.4, "mouthDimple": 0.3},
    "sad": {"mouthFrown": 1.0, "browInnerUp": 1.0, "mouthShrugLower": 0.5, "eyeSquint": 0.2},
    "angry": {"browDown": 1.0, "noseSneer": 0.7, "mouthPress": 0.6, "mouthFrown": 0.4, "eyeSquint": 0.5},
    "surprised": {"jawOpen": 0.6, "browInnerUp": 0.9, "browOuterUp": 0.9, "eyeWide": 1.0},
    "disgusted": {"noseSneer": 1.0, "mouthUpperUp": 0.7, "browDown": 0.5, "eyeSquint": 0.6, "mouthFrown": 0.3},
}

# Actions that anny has one of; of all others it has a left and a right one.
UNPAIRED = ("browInnerUp", "jawOpen", "mouthShrugLower")


def facial_actions(expression: str) -> dict[str, float]:
    """An expression by anny's own names: action → how far."""
    actions = {}
    for name, value in EXPRESSIONS[expression].items():
        sides = ("",) if name in UNPAIRED else ("Left", "Right")
        actions |= {name + side: value for side in sides}
    return actions
