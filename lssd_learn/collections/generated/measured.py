"""The measures of generated bodies: evaluates the body model in the rest pose. Used by `bodies.py`."""

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np

from lssd_learn.collections.anthropometry.measures import TOPOLOGY, Anthropometer, Tape, tape_parts
from lssd_learn.collections.generated.body.further import FURTHER_CHANGES
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.collections.generated.body.parts import body_parts
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh


def measured(people: Iterable[Mapping[str, float]]) -> np.ndarray:
    """(n, p) the `MEASURES` of n people, told by sliders in [0, 1] as `BodyModel.vertices` takes them."""
    every, meter = list(people), _anthropometer()
    further = not FURTHER_CHANGES.keys().isdisjoint(name for person in every for name in person)
    model = body_model(TOPOLOGY, further)
    return np.array([meter.measure(*model.rest(person)) for person in track(every, "measuring")])


def taped(person: Mapping[str, float]) -> tuple[Mesh, dict[str, Tape]]:
    """A person in the rest pose, and the tape of each girth on it."""
    model = body_model(TOPOLOGY)
    vertices, joints = model.rest(person)
    return Mesh(vertices, model.faces), _anthropometer().girths(vertices, joints)


@cache
def _anthropometer() -> Anthropometer:
    model = body_model(TOPOLOGY)
    return Anthropometer(model.faces, tape_parts(body_parts(model.bones, model.bone_weights), model.left))
