"""`.mrk.json`, the markups of 3D Slicer: one list of points a file, in LPS or RAS.

Reference:
    Slicer, Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json.
"""

import json
import math
from collections.abc import Sequence

import numpy as np

from lssd_learn.collections.landmark_files.specimen import SPACES, Specimen, specimen

SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
POINTS = ("Fiducial", "PointList")
STATUS = {"defined": True, "undefined": False, "missing": False, "preview": False}


def read(text: str) -> list[Specimen]:
    """The one list of points of a file; selected or not, locked or not, visible or not.

    A point whose position is not defined is missing. Curves, planes and other markups are left out.

    Raises:
        ValueError: no JSON of Slicer, none or two lists of points, a position that is not three numbers, another
            coordinate system.
    """
    try:
        whole = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"expected JSON: {error}") from None
    markups = whole.get("markups") if isinstance(whole, dict) else None
    if not isinstance(markups, list) or not all(isinstance(markup, dict) for markup in markups):
        raise ValueError("expected the markups of 3D Slicer, got other JSON")
    lists = [markup for markup in markups if markup.get("type") in POINTS]
    others = [str(markup.get("type")) for markup in markups if markup.get("type") not in POINTS]
    if len(lists) != 1:
        got = f"{len(lists)}" + (f" beside {', '.join(others)}" if others else "")
        raise ValueError(f"expected one list of points, got {got}")
    markup = lists[0]
    controls = markup.get("controlPoints", [])
    if not isinstance(controls, list) or not all(isinstance(point, dict) for point in controls):
        raise ValueError("expected a list of controlPoints")
    word = str(markup.get("coordinateSystem", "LPS"))  # the schema's default
    if word.casefold() not in SPACES:
        raise ValueError(f"expected coordinateSystem LPS or RAS, got {word[:30]!r}")
    labels = [str(point.get("label") or i + 1) for i, point in enumerate(controls)]
    points = [_position(point, label) for point, label in zip(controls, labels, strict=True)]
    notes = [f"left out {', '.join(others)}"] if others else []
    return [specimen("", labels, points, SPACES[word.casefold()], notes)]


def _position(point: dict, label: str) -> list[float]:
    status, position = point.get("positionStatus", "defined"), point.get("position")
    if status not in STATUS:
        raise ValueError(f"landmark {label!r}: expected positionStatus {', '.join(STATUS)}, got {str(status)[:30]!r}")
    if not STATUS[status] or position in (None, "", []):
        return [math.nan] * 3
    usual = isinstance(position, list) and len(position) == 3
    if not usual or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in position):
        raise ValueError(f"landmark {label!r}: expected a position of three numbers, got {str(position)[:60]}")
    if any(math.isinf(x) for x in position):
        raise ValueError(f"landmark {label!r}: expected finite numbers, got {str(position)[:60]}")
    return [float(x) for x in position]


def write(specimens: Sequence[Specimen]) -> str:
    """The file of one specimen, in its coordinate system; LPS, which Slicer expects, where it says none."""
    (one,) = specimens
    controls = []
    for i, (label, point) in enumerate(zip(one.labels, one.points, strict=True)):
        here = not np.isnan(point).any()
        controls.append(
            {"id": str(i + 1), "label": label, "description": "", "associatedNodeID": ""}
            | ({"position": point.tolist()} if here else {})
            | {
                "orientation": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                "selected": True,
                "locked": False,
                "visibility": True,
                "positionStatus": "defined" if here else "undefined",
            }
        )
    markup = {
        "type": "Fiducial",
        "coordinateSystem": one.space or "LPS",
        "locked": False,
        "labelFormat": "%N-%d",
        "controlPoints": controls,
        "measurements": [],
    }
    return json.dumps({"@schema": SCHEMA, "markups": [markup]}, indent=4) + "\n"
