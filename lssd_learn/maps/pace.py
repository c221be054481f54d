"""How long many maps will take, said once the first few of them have been timed, and what takes less."""

import logging
import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from joblib import cpu_count

from lssd_learn.collections.parallel import on_one_thread
from lssd_learn.progress import duration

log = logging.getLogger(__name__)

T = TypeVar("T")

TIMED = 3  # maps, the first of which may have to load what all share
LONG = 600.0  # seconds of one core from which it is worth a warning
HUBS = 4  # of network=hubs, unless it is told otherwise


def timed(compute: Callable[[int], T], pairs: Sequence[tuple[int, int]], workers: int | None) -> list[T]:
    """The maps of the first few of many pairs; a warning where all of them will take long.

    Args:
        compute: the number of a pair → its maps.
        pairs: of shapes, that have yet to be mapped.
        workers: processes, see `in_parallel`.

    Returns:
        Of the first pairs; none where the pairs are too few to take long at a minute each.
    """
    if len(pairs) <= LONG / 60:
        return []
    found = [on_one_thread(compute, 0)]
    start = time.monotonic()
    found += [on_one_thread(compute, p) for p in range(1, TIMED)]
    seconds = (time.monotonic() - start) / (TIMED - 1)
    if seconds * len(pairs) > LONG:
        shapes, processes = len({i for pair in pairs for i in pair}), workers or cpu_count()
        fewer = HUBS * (shapes - 1) - HUBS * (HUBS - 1) // 2
        log.warning(
            "%d maps at %.2g s each will take %s on one core%s%s",
            len(pairs), seconds, duration(seconds * len(pairs)),
            f", {duration(seconds * len(pairs) / processes)} on {processes}" * (processes > 1),
            f"; network=hubs needs {fewer} of them, {duration(seconds * fewer)}" * (2 * fewer < len(pairs)),
        )  # fmt: skip
    return found
