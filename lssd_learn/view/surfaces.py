"""Surfaces that become others: as files for other programs, as a picture, and for the page."""

import re
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from PIL import Image

from lssd_learn.exploration.surfaces.lent import Lender
from lssd_learn.exploration.surfaces.morphs import Morph
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.normals import normals
from lssd_learn.view.coloured import save_coloured
from lssd_learn.view.fields import Field
from lssd_learn.view.painter import paint
from lssd_learn.view.reports.stage import Way, encode
from lssd_learn.view.sheets import shape_sheet

SHOWN = 8  # morphs in the picture
PIXELS = 168  # of a thumbnail
OUT = "how far the surface moves out, in units of the files"


def plain(title: str) -> str:
    """A title as a file name, of letters that all systems take."""
    return re.sub(r"[^\w.+-]+", "_", title.replace(" → ", "-").replace("−", "-")).strip("_")


def moves(lender: Lender, morph: Morph) -> Float[np.ndarray, " V"]:
    """(V,) how far each vertex moves along its normal from one end of a morph to the other; of a cloud, whose normals
    have no sides, how far in any direction."""
    step = 2 * lender.functions @ morph.step
    if not isinstance(lender.shape, Mesh):
        return np.linalg.norm(step, axis=1)
    return (normals(lender.shape, lender.vertices(morph.middle)) * step).sum(1)


def move_fields(lender: Lender, morphs: Sequence[Morph], copies: int = 1) -> list[Field]:
    """A field a morph, of what `moves` tells, on `copies` shapes with the same vertices."""
    return [
        Field.signed(f"moves_{plain(morph.title)}", f"{morph.title}: {OUT}", [moves(lender, morph)] * copies)
        for morph in morphs
    ]


def ways(lender: Lender, morphs: Sequence[Morph], first: int) -> list[Way]:
    """Morphs for a page, whose fields from number `first` on are their `move_fields`."""
    return [
        Way(m.title, m.ends, lender.vertices(m.middle), lender.functions @ m.step, m.at, first + j)
        for j, m in enumerate(morphs)
    ]


def write_surfaces(
    folder: Path, lender: Lender, mean: Float[np.ndarray, "m 3"], morphs: Sequence[Morph], up: str | None
) -> None:
    """Write the mean surface and the two ends of each morph as PLY and GLB, in the colours of how far they have moved
    from one to the other, which PLY holds as numbers too.

    Args:
        folder: made if need be.
        lender: of the mesh and its detail.
        mean: (m, 3) coordinates.
        morphs: as mean, NAME_low and NAME_high.
        up: the axis that points up in the shape.
    """
    folder.mkdir(parents=True, exist_ok=True)
    grey = np.full((len(lender.functions), 3), 190, dtype=np.uint8)
    for suffix in (".ply", ".glb"):
        save_coloured(lender.surface(mean), grey, folder / f"mean{suffix}", up)
    for morph, field in zip(morphs, move_fields(lender, morphs), strict=True):
        for name, s in (("low", -1), ("high", 1)):
            for suffix in (".ply", ".glb"):
                path = folder / f"{plain(morph.title)}_{name}{suffix}"
                save_coloured(lender.surface(morph.x(s)), field.colours(0), path, up, {"moves": field.values[0]})


def surface_chart(lender: Lender, morphs: Sequence[Morph], up: str | None, azimuth: float = 20.0) -> Figure:
    """A row a morph: one end, the middle, the other end."""
    rows = {}
    for morph in morphs[:SHOWN]:
        titles = (morph.ends[0], "between", morph.ends[1])
        rows[morph.title] = {t: lender.surface(morph.x(s)) for t, s in zip(titles, (-1, 0, 1), strict=True)}
    return shape_sheet(rows, up, azimuth)


def thumbnail(lender: Lender, morph: Morph, s: float, up: str | None, azimuth: float) -> str:
    """The address of a square picture of a surface, which holds the picture itself."""
    image = paint(lender.surface(morph.x(s)), size=PIXELS, azimuth=azimuth, up=up or "y")
    side = max(image.shape[:2])
    square = np.full((side, side, 3), 255, dtype=np.uint8)
    top, left = (side - image.shape[0]) // 2, (side - image.shape[1]) // 2
    square[top : top + image.shape[0], left : left + image.shape[1]] = image
    stream = BytesIO()
    Image.fromarray(square).save(stream, format="PNG", optimize=True)
    return f"data:image/png;base64,{encode(np.frombuffer(stream.getvalue(), np.uint8))}"
