"""`task=summary task.folder=DIR`: the runs of a sweep as one table, grouped by everything but the seed.

Every sweep ends with the same, also when some of its jobs failed.
"""

from pathlib import Path

from lssd_learn.pieces import Pieces
from lssd_learn.sweeps.runs import read_runs
from lssd_learn.sweeps.summary import write
from lssd_learn.sweeps.table import summarise


def run(pieces: Pieces, out: Path, folder: str) -> dict[str, float]:
    """Write summary.csv, summary.md and summary.png into the folder of a sweep, from what its runs left there.

    Args:
        folder: its runs may lie at any depth.

    Returns:
        The numbers of runs, groups and failed runs.
    """
    table = summarise(read_runs(folder))
    write(table, Path(folder))
    return {"runs": sum(len(g.runs) + g.failed for g in table.groups), "groups": len(table.groups),
        "failed": len(table.failed)}  # fmt: skip
