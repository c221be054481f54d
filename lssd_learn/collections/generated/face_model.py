"""The parametric head behind `faces.py`: the head of anny's body, with its facial actions, one at a time.

It shares what takes long to build with the bodies (`body_model.load_anny`); its own part is eight seconds and 120 MB,
once.
"""

from collections.abc import Mapping
from functools import cache

import numpy as np

from lssd_learn.collections.generated.body.model import load_anny
from lssd_learn.shapes import Mesh, clean

# Our parameters that anny has as phenotypes: the values there at 0 and at 1. The three origins are weights of a mean.
PHENOTYPES = {
    "gender": ("gender", 0.0, 1.0),
    "age": ("age", 0.55, 1.0),  # grown-up
    "weight": ("weight", 0.2, 0.9),
    "african": ("african", 0.0, 1.0),
    "asian": ("asian", 0.0, 1.0),
    "caucasian": ("caucasian", 0.0, 1.0),
}
# And those it has as local changes, from −REACH to REACH: at their ends, ±1, several together are caricatures.
LOCAL_CHANGES = {
    "head_width": "head-scale-horiz-incr",
    "head_height": "head-scale-vert-incr",
    "forehead": "forehead-scale-vert-incr",
    "chin_width": "chin-width-incr",
    "chin_height": "chin-height-incr",
    "nose_length": "nose-scale-vert-incr",
    "nose_width": "nose-scale-horiz-incr",
    "nose_hump": "nose-hump-incr",
    "mouth_width": "mouth-scale-horiz-incr",
    "lips": "mouth-scale-vert-incr",
}
REACH = 0.6

# Places that anybody would find on a face: of the vertices that an action moves at least so much of what it moves most,
# the farthest in a direction, x from right to left, y from front to back, z up. None is no action, of all vertices.
LANDMARKS: dict[str, tuple[str | None, float, tuple[int, int, int]]] = {
    "mouth_corner_left": ("mouthPucker", 0.85, (1, 0, 0)),
    "mouth_corner_right": ("mouthPucker", 0.85, (-1, 0, 0)),
    "upper_lip": ("mouthShrugUpper", 0.9, (0, -1, 0)),
    "lower_lip": ("mouthShrugLower", 0.9, (0, -1, 0)),
    "chin": ("jawOpen", 0.7, (0, -1, -1)),
    "nose": (None, 0, (0, -1, 0)),
    "cheek_left": ("cheekSquintLeft", 1, (1, 0, 0)),
    "cheek_right": ("cheekSquintRight", 1, (-1, 0, 0)),
    "eyelid_left": ("eyeBlinkLeft", 1, (0, -1, 0)),
    "eyelid_right": ("eyeBlinkRight", 1, (0, -1, 0)),
    "brow_left": ("browOuterUpLeft", 1, (0, -1, 0)),
    "brow_right": ("browOuterUpRight", 1, (0, -1, 0)),
    "ear_left": (None, 0, (1, 0, 0)),
    "ear_right": (None, 0, (-1, 0, 0)),
    "crown": (None, 0, (0, 0, 1)),
    "nape": (None, 0, (0, 1, 0)),
}

PARAMETERS = (*PHENOTYPES, *LOCAL_CHANGES)
FIXED = {"muscle": 0.5, "height": 0.5, "proportions": 0.5}


class FaceModel:
    """anny's head down to the neck, with its mouth and the sockets of its eyes; without eyes, tongue and body.

    Attributes:
        faces: (F, 3) int64, the same for every head, oriented outward; the neck is open.
        actions: the names of its facial actions.
        landmarks: name → vertex, of `LANDMARKS`.
    """

    def __init__(self):
        self._model = load_anny("head", list(LOCAL_CHANGES.values()), facial_actions="all", phenotypes="all")
        template = Mesh(self._model.template_vertices.numpy(), self._model.get_triangular_faces().numpy())
        whole = clean(template, "head template")
        self.faces = whole.mesh.faces
        self.actions = list(self._model.facial_action_labels)
        self._kept = whole.vertex_index
        self.landmarks = self._landmarks()

    def vertices(self, parameters: Mapping[str, float], actions: Mapping[str, float]) -> np.ndarray:
        """(V, 3) float64 vertices in metres, Z up, looking towards −y, where the head is on a standing body.

        Args:
            parameters: of `PARAMETERS`, in [0, 1].
            actions: how far each facial action goes, 0 to 1; the others rest.
        """
        import torch

        pose = torch.eye(4, dtype=self._model.dtype).repeat(1, len(self._model.bone_labels), 1, 1)
        phenotypes = FIXED | {
            theirs: low + (high - low) * parameters[ours] for ours, (theirs, low, high) in PHENOTYPES.items()
        }
        changes = {theirs: REACH * (2 * parameters[ours] - 1) for ours, theirs in LOCAL_CHANGES.items()}
        threads = torch.get_num_threads()
        torch.set_num_threads(1)  # the same bits on any number of cores
        try:
            with torch.no_grad():
                how = {"facial_actions": dict(actions), "pose_parameterization": "local-ref"}
                out = self._model(pose, phenotypes, changes, **how)
        finally:
            torch.set_num_threads(threads)
        return out["vertices"][0].numpy()[self._kept]

    def _landmarks(self) -> dict[str, int]:
        """On the head in the middle of all parameters."""
        middle = dict.fromkeys(PARAMETERS, 0.5)
        rest = self.vertices(middle, {})
        found = {}
        for name, (action, share, direction) in LANDMARKS.items():
            actions = {} if action is None else {action: 1.0}
            moved = np.linalg.norm(self.vertices(middle, actions) - rest, axis=1)
            reach = rest @ np.array(direction, dtype=float)
            found[name] = int(np.where(moved >= share * moved.max(), reach, -np.inf).argmax())
        return found


@cache
def face_model() -> FaceModel:
    """The model, loaded once a process (about a second; a minute the very first time)."""
    return FaceModel()
