"""What a run with computed maps leaves of them: a table of how far each can be trusted, and the worst in a picture."""

import logging
from pathlib import Path
from typing import cast

from lssd_learn.maps import ComputedMaps
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh
from lssd_learn.view.matches import Pair, match_sheet
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE, PICTURE = "map_quality.csv", "map_quality.png"
SHOWN = 4  # pairs, the worst


def leave_qualities(pipeline: Pipeline, out: Path) -> None:
    """Write map_quality.csv, a row a map of the network, the worst first, and map_quality.png of the worst.

    Nothing is written where no maps were computed in the run, or nothing is known of their quality.

    Args:
        pipeline: of the run.
        out: its folder.
    """
    rows = pipeline.map_qualities()
    if not rows:
        return
    write_rows(rows, out / TABLE)
    collection, maps = pipeline.collection, cast(ComputedMaps, pipeline.pair_maps())
    number = {name: i for i, name in enumerate(collection.names)}
    pairs = []
    for row in rows[:SHOWN]:
        i, j = number[str(row["source"])], number[str(row["target"])]
        title = f"{row['source']} and {row['target']}: quality {row['quality']:.2f}"
        pairs.append(Pair(title, cast(Mesh, collection[i]), cast(Mesh, collection[j]), maps.vertices(i, j)))
    match_sheet(pairs).savefig(out / PICTURE)
    bad = sum(not row["trusted"] for row in rows)
    log.info("%d computed maps, %d not to be trusted: %s, the worst in %s", len(rows), bad, out / TABLE, PICTURE)
