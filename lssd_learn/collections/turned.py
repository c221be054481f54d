"""Shapes turned at random, as scanners leave them: what a method that needs no upright pose is tested on."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape

TURNED = ("none", "vertical", "any")


def check_turned(turned: str) -> None:
    """Refuse anything but one of `TURNED`.

    Raises:
        InputError: names the choices.
    """
    if turned not in TURNED:
        raise InputError(f"collection.turned={turned}: expected one of {', '.join(TURNED)}")


def turned_shape(shape: Shape, turned: str, seed: int, i: int) -> Shape:
    """A shape as it lies after a random turn about the origin.

    Args:
        shape: number i of a collection.
        turned: "none"; "vertical", about z; "any", a rotation that is uniform among all.
        seed, i: each shape has a turn of its own.
    """
    if turned == "none":
        return shape
    rng = np.random.default_rng([seed, i, 1])  # a stream of its own: what is turned stays what it is
    vertical = turned == "vertical"
    turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)) if vertical else Rotation.random(rng=rng)
    points = shape.vertices @ turn.as_matrix().T
    return replace(shape, vertices=points) if isinstance(shape, Mesh) else PointCloud(points)
