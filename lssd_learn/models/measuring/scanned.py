"""What a reader is made from: people, and scans of others, of which it is seen how well they are read."""

from dataclasses import fields

import numpy as np

from lssd_learn.collections import Faulty, People, Remeshed
from lssd_learn.collections.generated.skinned import MARKS, Skin, Skinned
from lssd_learn.models.measuring import figure
from lssd_learn.progress import track

POINTS = 8000  # of a cloud


def kinds_of_scans(people: People, scans: int, vertices: tuple[int, int]) -> tuple[Remeshed, Remeshed, Faulty]:
    """Meshes, clouds and faulty meshes of other people of the same kind, turned anyhow: a quarter, a quarter, a half.

    Args:
        people: who is not among them.
        scans: how many.
        vertices: of a mesh, anywhere in between.
    """
    kind = {"jitter": people.jitter, "poses": people.poses, "ages": people.ages, "further": people.further}
    quarter = scans // 4
    kinds = (quarter, "mesh", vertices), (quarter, "cloud", (POINTS, POINTS)), (scans - 2 * quarter, "mesh", vertices)
    meshes, clouds, others = (
        Remeshed(People(count, people.seed + number, **kind), what, points, people.seed, turned="any")
        for number, (count, what, points) in enumerate(kinds, 1)
    )
    return meshes, clouds, Faulty(others, seed=people.seed)


def learnt_from(people: People) -> figure.People:
    """How they vary and bend."""
    skin, found = Skin(people.further > 0), {field.name: [] for field in fields(Skinned)}
    for row in track(people.sliders[:: people.scans].tolist(), "people"):
        person = skin.of(dict(zip(people.slider_names, row, strict=True)))
        for name, values in found.items():
            values.append(getattr(person, name).astype(np.float32))
    stacked = {name: np.stack(values) for name, values in found.items()}
    return figure.People(skin.faces, skin.parents, skin.joints, skin.shares, **stacked, names=MARKS, masks=skin.parts)
