"""The measures of generated bodies: evaluates the body model in the rest pose. Used by `bodies.py`."""

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from scipy.spatial import ConvexHull

from lssd_learn.collections.anthropometry.measures import (
    PART,
    TOPOLOGY,
    Anthropometer,
    Tape,
    edges_within,
    tape_parts,
)
from lssd_learn.collections.anthropometry.sections import between, crossed
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.collections.generated.body.parts import body_parts
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh


def measured(people: Iterable[Mapping[str, float]]) -> np.ndarray:
    """(n, p) the `MEASURES` of n people, told by sliders in [0, 1] as `BodyModel.vertices` takes them."""
    model, meter = body_model(TOPOLOGY), _anthropometer()
    return np.array([meter.measure(*model.rest(person)) for person in track(list(people), "measuring")])


def taped(person: Mapping[str, float]) -> tuple[Mesh, dict[str, Tape]]:
    """A person in the rest pose, and the tape of each girth on it."""
    model = body_model(TOPOLOGY)
    vertices, joints = model.rest(person)
    return Mesh(vertices, model.faces), _anthropometer().girths(vertices, joints)


def girth_loops(topology: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Name of each girth → where its tape lies on bodies of a topology: corners (h, 2) on edges, shares (h,) of these.

    Where the plane of the tape on the person in the middle of all sliders cuts the edges of that part of the body, as
    far as the tape touches them.
    """
    model = body_model(topology)
    middle: dict[str, float] = {}
    vertices, _ = model.rest(middle)
    masks = tape_parts(body_parts(model.bones, model.bone_weights), model.left)
    loops = {}
    for name, tape in taped(middle)[1].items():
        centre = tape.points.mean(0)
        plane = np.linalg.svd(tape.points - centre)[2]
        ends, share = crossed(vertices, edges_within(model.faces, masks[PART[name]]), centre, plane[2])
        around = ConvexHull((between(vertices, ends, share) - centre) @ plane[:2].T).vertices
        loops[name] = ends[around], share[around]
    return loops


@cache
def _anthropometer() -> Anthropometer:
    model = body_model(TOPOLOGY)
    return Anthropometer(model.faces, body_parts(model.bones, model.bone_weights), model.left)
