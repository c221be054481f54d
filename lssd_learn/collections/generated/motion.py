"""Generated characters in motion: what the paper takes Dynamic FAUST for, thousands of shapes of a few people.

The bodies are those of `bodies.py`, as many as there are characters; `motions.py` says how they move.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.motions import MOTIONS, angles
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh

# Goes up whenever the same arguments give other shapes; what stands in `MOTIONS` is part of the key anyway.
GENERATOR_VERSION = 1


class Motion(Collection):
    """Characters going through motions, in metres, Z up, the lowest vertex at z = 0.

    Frame by frame, motion by motion, character by character. No shape depends on how many others there are: more
    characters or motions leave those that were there as they are, and twice the frames fall between them.

    Args:
        characters: how many; character i has the parameters of body i of `Bodies` of the same seed.
        motions: some of `MOTIONS`.
        frames: of each motion, evenly spaced in time; the motion then starts again.
        seed: of the parameters.
        topology: see `Bodies`.

    Attributes:
        parameters: (n, 12) float64 in [0, 1], of the character: its body, whatever it does.
        groups: "character" and "motion": (n,) names each.
        parts: those of `Bodies`; loads the body model.

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        characters: int = 10,
        motions: Sequence[str] = tuple(MOTIONS),
        frames: int = 64,
        seed: int = 0,
        topology: str = "notoes_collapse10pc",
    ):
        check_whole("characters", characters, 1)
        check_whole("frames", frames, 1)
        motions = [motions] if isinstance(motions, str) else [str(motion) for motion in motions]
        if not motions or len(set(motions)) < len(motions) or not set(motions) <= set(MOTIONS):
            raise InputError(f"motions: expected some of {', '.join(MOTIONS)}, each once, got {motions}")
        self.bodies = Bodies(characters, seed, topology)
        self.frames = frames
        # Of each shape its character, motion and frame.
        self.places = [(c, motion, f) for c in range(characters) for motion in motions for f in range(frames)]
        self.names = [f"{_character(c)}_{motion}_{f:03d}" for c, motion, f in self.places]
        self.parameter_names = self.bodies.parameter_names
        self.parameters = np.repeat(self.bodies.parameters, len(motions) * frames, axis=0)
        self.parameters.flags.writeable = False
        self.groups = {
            "character": np.array([_character(c) for c, _, _ in self.places]),
            "motion": np.array([motion for _, motion, _ in self.places]),
        }
        self._motion_keys = {motion: fingerprint("motion", GENERATOR_VERSION, _plain(motion)) for motion in motions}
        self.key = fingerprint("motions", self.bodies.key, self._motion_keys, frames)

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, i: int) -> Mesh:
        character, motion, frame = self.places[i]
        body = self.bodies.make(self.bodies.parameters[character], angles(motion, frame / self.frames))
        return Mesh(body.vertices - [0, 0, body.vertices[:, 2].min()], body.faces)

    @cached_property
    def parts(self) -> Mapping[str, np.ndarray]:
        return self.bodies.parts

    def shape_key(self, i: int) -> str:
        character, motion, frame = self.places[i]
        return fingerprint(self.bodies.shape_key(character), self._motion_keys[motion], frame / self.frames)


def _character(c: int) -> str:
    return f"character{c:02d}"


def _plain(motion: str) -> list:
    """The table of a motion as a cache key takes it."""
    return [[bone, [[moment, *keys[moment]] for moment in sorted(keys)]] for bone, keys in MOTIONS[motion].items()]
