"""Reading and writing shapes: OFF, OBJ, PLY, STL, GLB, VTK, VTP, XYZ. Coordinates are neither turned nor scaled.

Vertices keep the order of the file in every format but STL, which has none. The formats are in `reading/` and
`writing.py`; what is wrong with a shape that was read as it is, is for `clean.py`.
"""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from lssd_learn.errors import InputError, reading
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes.edges import edge_lengths, edges
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape
from lssd_learn.shapes.reading import READERS, space_of, what_it_is
from lssd_learn.shapes.writing import WRITERS
from lssd_learn.written import whole

log = logging.getLogger(__name__)

FORMATS = tuple(READERS)
LOST, FEW = 0.1, 1e-3  # a step of float32 over the distance of neighbours: the shape is lost, or only just there
SOME = 1000  # points of a cloud whose neighbours are looked for


@dataclass(frozen=True, eq=False)
class Reading:
    """What `read` found.

    Attributes:
        shape: in the coordinates of the file.
        notes: in short phrases, what was left out or guessed.
        space: "LPS" or "RAS", the coordinate system, where the file says it, as those of 3D Slicer do; "".
        colours: (V, 3) of the vertices, 0 to 1, of a PLY that has them.
    """

    shape: Shape
    notes: tuple[str, ...]
    space: str = ""
    colours: Float[np.ndarray, "V 3"] | None = None


def load(path: str | Path) -> Shape:
    """Read one shape: a `Mesh` if the file has faces, otherwise a `PointCloud`. Polygons are cut into triangles.

    What is left out (lines, columns that are no coordinates) or guessed is told as a warning in the log.

    Raises:
        InputError: no such file, another format, a damaged, truncated or empty file, a file with a part that is not
            understood, coordinates that are not finite or so far from the origin that they have no digits left.

    Examples:
        >>> import tempfile
        >>> import lssd_learn as lssd
        >>> path = f"{tempfile.mkdtemp()}/triangle.ply"
        >>> lssd.save(lssd.Mesh([[0, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2]]), path)
        >>> float(lssd.load(path).area)
        1.0
    """
    found = read(path)
    if found.notes:
        log.warning("%s: %s", path, ", ".join(found.notes))
    return found.shape


def read(path: str | Path) -> Reading:
    """As `load`, with what it would log."""
    path = Path(path)
    suffix = _suffix(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    with reading(path):
        data = path.read_bytes()
    if not data.strip():
        raise InputError(f"{path}: expected a shape, the file is empty")
    kind = suffix[1:].upper()
    try:
        content = what_it_is(data) or suffix
        with np.errstate(all="ignore"):
            parsed = READERS[content](data)
    except Exception as error:  # a damaged file fails in ways that no reader foresees
        reason = str(error).strip().splitlines() or [type(error).__name__]
        raise InputError(f"{path}: expected {kind}, it is damaged, cut off or something else: {reason[0]}") from error
    if len(parsed.vertices) == 0:
        raise InputError(f"{path}: expected a mesh or a point cloud, found no vertices")
    try:
        shape = Mesh(parsed.vertices, parsed.faces) if len(parsed.faces) else PointCloud(parsed.vertices)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    renamed = (f"it is {content[1:].upper()}, not {kind}, and read as such",) if content != suffix else ()
    notes = (*renamed, *parsed.notes, *_digits(shape, path))
    return Reading(shape, notes, parsed.space or space_of(data), parsed.colours)


def save(shape: Shape, path: str | Path) -> None:
    """Write `shape` in the format of the suffix; the file appears complete or not at all.

    Raises:
        InputError: an unknown suffix, a folder that is not there, a cloud as STL (which has only faces), a mesh as
            XYZ (which has none).

    Examples:
        >>> import tempfile
        >>> import numpy as np
        >>> import lssd_learn as lssd
        >>> lssd.save(lssd.PointCloud(np.eye(3)), f"{tempfile.mkdtemp()}/three_points.ply")
    """
    path = Path(path)
    suffix = _suffix(path)
    if isinstance(shape, PointCloud) and suffix == ".stl":
        raise InputError(f"{path}: STL holds faces only, a point cloud needs one of .ply .glb .obj .off .vtk .vtp .xyz")
    if isinstance(shape, Mesh) and suffix == ".xyz":
        raise InputError(f"{path}: XYZ holds points only, a mesh needs one of .off .obj .ply .stl .glb .vtk .vtp")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    data = WRITERS[suffix](shape)
    with whole(path) as draft:
        draft.write_bytes(data)


def _suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"{path}: expected one of {' '.join(FORMATS)}, got {suffix or 'no suffix'!r}")
    return suffix


def _digits(shape: Shape, path: Path) -> tuple[str, ...]:
    """A note on a shape whose coordinates are float32 and far from the origin.

    Raises:
        InputError: so far that neighbours have one place.
    """
    points = shape.points
    with np.errstate(over="ignore"):
        short = points.astype(np.float32)
    if not (short == points).all() or len(points) < 4 or (points == np.round(points)).all():
        return ()
    if isinstance(shape, Mesh):
        apart = edge_lengths(points, edges(shape.faces))
    else:
        apart = cKDTree(points).query(points[:: -(-len(points) // SOME)], 2)[0][:, 1]
    if not apart.any():
        return ()
    apart = np.median(apart[apart > 0])
    step = float(np.spacing(np.abs(short).max()))
    if step <= FEW * apart:
        return ()
    told = f"its coordinates have steps of {step:.2g}, being float32 and far from the origin, where neighbours are"
    if step > LOST * apart:
        raise InputError(f"{path}: {told} {apart:.2g} apart: expected them nearer to the origin, or with more digits")
    return (f"{told} {apart:.2g} apart",)
