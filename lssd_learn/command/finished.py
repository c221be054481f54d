"""What of a sweep is done: a job that an earlier one has finished in the same folder is kept. Used by `app.py`."""

import json
import logging
import shlex
from collections.abc import Sequence
from pathlib import Path

from lssd_learn.sweeps.runs import METRICS

log = logging.getLogger(__name__)

PROVENANCE = "provenance.json"  # written before the metrics: where these are, the run has come to its end


def finished(out: Path, overrides: Sequence[str]) -> dict[str, float] | None:
    """The metrics of a job that has come to its end with the same overrides, `ckpt_path=last` apart; None where it is
    to be run. Either is said in the log.

    Args:
        out: the folder of the job.
        overrides: of the job that is now to be run there.
    """
    try:
        metrics = json.loads((out / METRICS).read_text(encoding="utf-8"))
        words = shlex.split(json.loads((out / PROVENANCE).read_text(encoding="utf-8"))["command"])
        made_with = words[2 if words[:1] == ["python"] else 1 :]  # train.py, or lssd
    except (OSError, ValueError, KeyError, TypeError):
        return None  # missing, or damaged
    theirs, ours = (sorted(o for o in some if o != "ckpt_path=last") for some in (made_with, overrides))
    if theirs != ours:
        log.warning("%s holds a run of %s; it is made anew, of %s", out, " ".join(made_with), " ".join(overrides))
        return None
    log.info("%s was finished before and is kept: %s", out, " ".join(overrides))
    return metrics
