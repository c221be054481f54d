"""`task=landmarks`: some shapes have landmarks; the others get them through the maps, each with an error bar."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lssd_learn.collections.checked import ensure_checked
from lssd_learn.collections.landmark_files.files import FORMATS, write_specimens
from lssd_learn.collections.landmark_files.specimen import Specimen
from lssd_learn.collections.landmark_files.table import write_table
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.carrying import Asked, asked, choose_hubs, metrics_of, named_hubs, slips_of, tell
from lssd_learn.maps.carrying.carry import Carried, carry, pairs_of
from lssd_learn.maps.needs import ensure_mappable
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.view.landmarks.page import Sheet, write_landmark_page

log = logging.getLogger(__name__)

TABLE, PAGE, FILES = "landmarks.csv", "landmarks.html", "markups"


def run(
    pieces: Pieces, out: Path, hubs: Sequence[str] = (), most: int = 7, formats: Sequence[str] = ("mrk.json",)
) -> dict[str, float]:
    """Carry the landmarks of some shapes to the others; write landmarks.csv of all, their files and a page.

    Args:
        hubs: names of the shapes whose landmarks are carried; none leaves the choice to `choose_hubs`.
        most: hubs, where nobody names them.
        formats: of the files in markups/, beside the table; some of `landmark_files.files.FORMATS`.

    Returns:
        "shapes", those that got landmarks; "landmarks", how many they got; "left_out", shapes that got none; "hubs";
        "hub_error", how far the hubs' own are off where the others say them, and "error_bar", the mean, in the units of
        the shapes.

    Raises:
        InputError: no shape has landmarks, or all have them all; an unknown hub or format; shapes that are no meshes.
    """
    check_whole("task.most", most, 1)
    for form in formats:
        if form not in FORMATS:
            raise InputError(f"task.formats: expected some of {', '.join(FORMATS)}, got {form!r}")
    pipeline = pieces.pipeline
    ensure_checked(pipeline.collection, pipeline.cache)
    given = asked(pipeline.collection)
    chosen = named_hubs(given, hubs) if hubs else choose_hubs(pipeline.bases, given, most)
    found = carry_all(pipeline, given, chosen, given.lacking)
    points, bars, new = found.filled(given.points)
    names = given.collection.names
    write_table(out / TABLE, names, given.labels, points, bars, new)
    some = np.flatnonzero(np.isfinite(points).any(axis=(1, 2))).tolist()
    sets = [Specimen(names[i], tuple(given.labels), points[i], given.collection.space(i)) for i in some]
    (out / FILES).mkdir(exist_ok=True)
    for form in formats:
        write_specimens(sets, out / FILES, form)
    lost, slips = [names[i] for i in found.lost], slips_of(given, found, chosen)
    write_landmark_page(
        out / PAGE, Sheet(given.collection, names, given.labels, points, bars, new, chosen, lost, slips)
    )
    tell(given, found, chosen)
    log.info("%s (open it in a browser), %s, files in %s", PAGE, TABLE, FILES)
    return metrics_of(given, found, chosen)


def carry_all(pipeline: Pipeline, given: Asked, hubs: Sequence[int], shapes: Sequence[int]) -> Carried:
    """The landmarks of the hubs on these shapes, as they lie in their files.

    Raises:
        InputError: shapes that the maps cannot map.
    """
    ensure_mappable(pipeline.maps, pipeline.collection)
    maps = pipeline.pair_maps()
    maps.prepare(pairs_of(hubs, shapes), pipeline.workers)
    return carry(given.collection, maps, hubs, shapes, given.points[list(hubs)], pipeline.workers)
