"""The part of each mesh that is looked at: its outside, a list of its vertices, or what is painted. For `shape.py`.

What a mask takes is cut away before anything else is done with the shape, as if the file did not hold it.
"""

from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.reading.listing import beside, read_indices
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.clean import Cleaned, cut
from lssd_learn.shapes.edges import face_groups
from lssd_learn.shapes.mending.outside import seen_from_outside

MASKS = (None, "outer", "vertices", "painted")
MASK_VERSION = 1  # goes up whenever the same mask leaves something else
STAGE, FOLDER = "mask", "mask"
# Of bone walls the outer side is seen from a quarter of all directions or more, the inner side, through openings, from
# a tenth at most, and little lies between.
OUTER = 1 / 8
SPECK = 1e-3  # of the area: a smaller patch goes with what is around it
LEAST = 0.05  # of the area: with less left, the mask cannot be meant
PAINTED = 0.25  # of the range of a colour, between its strongest and its weakest part: below it is a grey


class Masks:
    """The masks of the shapes of a folder.

    Args:
        kind: "outer": faces that are seen from an eighth of all directions at least, see `seen_from_outside`, patches
            of less than a thousandth of the area going with what is around them; "vertices": faces with all three
            vertices in the list `mask/NAME.txt`, counted from 0, one a line; "painted": faces whose three vertices
            have a colour in the file (PLY) that is no grey; None: all.
        parent: the folder of the shapes.
        names: of the shapes.

    Raises:
        InputError: another kind; "vertices" and a list that is not there.
    """

    def __init__(self, kind: str | None, parent: Path, names: Sequence[str]):
        if kind not in MASKS:
            raise InputError(f"mask: expected {', '.join(map(str, MASKS[1:]))} or null, got {kind!r}")
        self.kind = kind
        self.cache: Cache | None = None  # where what is seen from outside is kept: a second or two a shape
        self.files = beside(parent, FOLDER, names) if kind == "vertices" else []
        self._outer: dict[int, Bool[np.ndarray, " F"]] = {}

    def __bool__(self) -> bool:
        return self.kind is not None

    def cut(
        self, i: int, whole: Cleaned, original: Mesh, colours: Float[np.ndarray, "V 3"] | None, name: str
    ) -> Cleaned:
        """What the mask leaves of shape i.

        Args:
            i: its position.
            whole: the mended mesh.
            original: what the file holds, V vertices.
            colours: of its vertices, 0 to 1, where the file has any.
            name: of the file.

        Raises:
            InputError: a vertex that is not there, no colours, or less than a twentieth of the area left.
        """
        stays = self._faces(i, whole, original, colours, name)
        left = whole.mesh.face_areas[stays].sum() / whole.mesh.area
        if left < LEAST:
            raise InputError(
                f"{name}: expected a mask that leaves something of the shape, {self.kind} leaves {100 * left:.2g} % of "
                f"its area (collection.mask)"
            )
        return cut(whole, stays, f"mask {self.kind} took {100 * (1 - left):.0f} % of the area")

    def _faces(
        self, i: int, whole: Cleaned, original: Mesh, colours: np.ndarray | None, name: str
    ) -> Bool[np.ndarray, " F"]:
        if self.kind == "outer":
            if i not in self._outer:
                self._outer[i] = self._kept(whole.mesh)
            return self._outer[i]
        chosen = np.zeros(len(original.vertices), dtype=bool)
        if self.kind == "vertices":
            vertices = read_indices(self.files[i])
            if wrong := [v for v in vertices.tolist() if not 0 <= v < len(chosen)]:
                raise InputError(
                    f"{self.files[i]}: expected vertices of {name}, 0 to {len(chosen) - 1}, got {wrong[0]}"
                )
            chosen[vertices] = True
        elif colours is None:
            raise InputError(f"{name}: expected colours at its vertices (PLY) for collection.mask=painted, it has none")
        else:
            chosen = np.ptp(colours, axis=1) > PAINTED
        # A vertex that others at its place were merged into stands for all of them.
        there = np.zeros(len(whole.mesh.vertices), dtype=bool)
        there[whole.new_index[chosen & (whole.new_index >= 0)]] = True
        return np.asarray(there[whole.mesh.faces].all(axis=1))

    def _kept(self, mesh: Mesh) -> Bool[np.ndarray, " F"]:
        if self.cache is None:
            return outer_faces(mesh)
        content = blake2b(mesh.vertices.tobytes(), digest_size=16).hexdigest()
        key = fingerprint(STAGE, MASK_VERSION, mesh.connectivity, content)
        return self.cache.get(STAGE, key, lambda: {"outer": outer_faces(mesh)})["outer"]


def outer_faces(mesh: Mesh) -> Bool[np.ndarray, " F"]:
    """(F,) the faces of the outside of a mesh, see `Masks`."""
    outer = seen_from_outside(mesh.vertices, mesh.faces) >= OUTER
    patch = face_groups(mesh.faces, outer)
    area = np.bincount(patch, mesh.face_areas)
    return outer ^ (area < SPECK * mesh.area)[patch]
