"""A person as the weights of a body tell it: at rest, where it is measured, and bent as it stands on a scan."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from lssd_learn.collections.anthropometry.measures import Anthropometer
from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.matching.surface import on_faces
from lssd_learn.models.measuring.posable import Lying, Posable
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.normals import normals

LEAST = 1e-4  # metres, root mean square of a vertex: modes along which people vary less are left out
NEAR = 4  # vertices around which the triangle under a tape is looked for


@dataclass(frozen=True, eq=False)
class People:
    """Known people, all in metres: what `Figure.of` learns from. See `Posable` for what is not said.

    Attributes:
        faces: (F, 3), parents (B,), joints and shares (V, f).
        parts: (n, V, f, 3) where what follows each joint lies while none is turned, times the share.
        heads: (n, B, 3) joints.
        rest: (n, V, 3) vertices as they are measured, and marks (n, M, 3) joints by which, whose names these are.
        masks: name → (V,) what tapes go around.
    """

    faces: Int[np.ndarray, "F 3"]
    parents: Int[np.ndarray, " B"]
    joints: Int[np.ndarray, "V f"]
    shares: Float[np.ndarray, "V f"]
    parts: Float[np.ndarray, "n V f 3"]
    heads: Float[np.ndarray, "n B 3"]
    rest: Float[np.ndarray, "n V 3"]
    marks: Float[np.ndarray, "n M 3"]
    names: Sequence[str]
    masks: Mapping[str, Bool[np.ndarray, " V"]]


@dataclass(frozen=True, eq=False)
class Figure:
    """A body that varies and bends, and what it measures.

    Attributes:
        body: of V vertices and r modes.
        rest, rest_modes: (V, 3), (r, V, 3) where vertices are as they are measured.
        marks, mark_modes: (M, 3), (r, M, 3) joints by which, whose names these are.
        masks: name → (V,) what tapes go around.
    """

    body: Posable
    rest: Float[np.ndarray, "V 3"]
    rest_modes: Float[np.ndarray, "r V 3"]
    marks: Float[np.ndarray, "M 3"]
    mark_modes: Float[np.ndarray, "r M 3"]
    names: Sequence[str]
    masks: Mapping[str, Bool[np.ndarray, " V"]]

    @classmethod
    def of(cls, people: People, most: int) -> "Figure":
        """The mean and the first principal components of all that varies, `most` at most, rounded to half precision."""
        n, (v, f), b = len(people.rest), people.shares.shape, people.heads.shape[1]
        used = np.flatnonzero(people.shares.ravel() > 0)
        parts = people.parts.reshape(n, v * f, 3)[:, used]
        every = np.concatenate([parts, people.heads, people.rest, people.marks], axis=1).astype(np.float32)
        mean = every.mean(axis=0)
        rows = (every - mean).reshape(n, -1)
        squares, vectors = np.linalg.eigh((rows @ rows.T).astype(float))
        order = np.argsort(-squares, kind="stable")[:most]
        order = order[squares[order] > (n - 1) * v * LEAST**2]
        found = vectors[:, order].T.astype(np.float32) @ rows / np.float32(np.sqrt(n - 1))
        sign = np.sign(found[np.arange(len(order)), np.abs(found).argmax(axis=1)])
        modes = (found * sign[:, None]).astype(np.float16).astype(float).reshape(len(order), *mean.shape)
        ends = np.cumsum([len(used), b, v])
        means, changes = np.split(mean.astype(float), ends), np.split(modes, ends, axis=1)
        return cls(
            _posable(people.faces, people.parents, people.joints, people.shares, used, means, changes),
            means[2], changes[2], means[3], changes[3], tuple(people.names), people.masks,
        )  # fmt: skip

    @cached_property
    def meter(self) -> Anthropometer:
        """What measures bodies of these vertices."""
        return Anthropometer(self.body.faces, self.masks)

    def at_rest(self, weights: Float[np.ndarray, " r"]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """(V, 3) vertices of a person as it is measured, and name → (3,) the joints by which."""
        r = len(weights)
        marks = self.marks + np.tensordot(weights, self.mark_modes[:r], 1)
        return self.rest + np.tensordot(weights, self.rest_modes[:r], 1), dict(zip(self.names, marks, strict=True))

    def measured(self, weights: Float[np.ndarray, " r"]) -> Float[np.ndarray, " p"]:
        """(p,) the `MEASURES` of a person, in their units."""
        return self.meter.measure(*self.at_rest(weights))

    def tapes(self, weights: Float[np.ndarray, " r"], lying: Lying) -> dict[str, Float[np.ndarray, "h 3"]]:
        """Name of each girth → (h, 3) where its tape goes along on the body as it lies."""
        rest, marks = self.at_rest(weights)
        tree, faces, found = cKDTree(rest), self.body.faces, {}
        for name, tape in self.meter.girths(rest, marks).items():
            around, shares = on_faces(faces, rest, tree.query(tape.points, NEAR)[1], tape.points)
            found[name] = np.einsum("hc,hcx->hx", shares, lying.points[faces[around]])
        return found

    def packed(self) -> dict[str, np.ndarray]:
        """Arrays for a file."""
        body = self.body
        used = np.flatnonzero(body.shares.ravel() > 0)
        parts = body.modes.reshape(body.shares.size, 3, -1)[used].transpose(2, 0, 1)
        every = (parts, body.head_modes, self.rest_modes, self.mark_modes)
        means = (body.mean.reshape(-1, 3)[used], body.heads, self.rest, self.marks)
        return {
            "faces": body.faces.astype(np.int32),
            "parents": body.parents.astype(np.int32),
            "joints": body.joints.astype(np.uint8),
            "shares": body.shares.astype(np.float32),
            "means": np.concatenate(means).astype(np.float32),
            "modes": np.concatenate(every, axis=1).astype(np.float16),
            "marks": np.array(self.names),
            "mask_names": np.array(list(self.masks)),
            "masks": np.packbits(np.stack(list(self.masks.values())), axis=1),
        }

    @classmethod
    def unpacked(cls, arrays: Mapping[str, np.ndarray]) -> "Figure":
        """What `packed` made arrays of.

        Raises:
            KeyError, ValueError: they are others.
        """
        shares = arrays["shares"].astype(float)
        joints, names = arrays["joints"].astype(int), tuple(arrays["marks"].tolist())
        used, v, b = np.flatnonzero(shares.ravel() > 0), len(shares), len(arrays["parents"])
        ends = np.cumsum([len(used), b, v])
        means, changes = (
            np.split(arrays["means"].astype(float), ends),
            np.split(arrays["modes"].astype(float), ends, axis=1),
        )
        body = _posable(
            arrays["faces"].astype(int), arrays["parents"].astype(int), joints, shares, used, means, changes
        )  # fmt: skip
        masks = np.unpackbits(arrays["masks"], axis=1, count=v).astype(bool)
        named = dict(zip(arrays["mask_names"].tolist(), masks, strict=True))
        return cls(body, means[2], changes[2], means[3], changes[3], names, named)


def _posable(
    faces: np.ndarray, parents: np.ndarray, joints: np.ndarray, shares: np.ndarray, used: np.ndarray,
    means: Sequence[np.ndarray], changes: Sequence[np.ndarray],
) -> Posable:  # fmt: skip
    """Of what follows joints, where only `used` places have a share, and of joints."""
    mean, modes = np.zeros((shares.size, 3)), np.zeros((shares.size, 3, len(changes[0])))
    mean[used], modes[used] = means[0], changes[0].transpose(1, 2, 0)
    mean, modes = mean.reshape(*shares.shape, 3), modes.reshape(*shares.shape, 3, -1)
    facing = normals(Mesh(mean.sum(axis=1), faces))
    return Posable(faces, parents, joints, shares, mean, modes, means[1], changes[1], facing)
