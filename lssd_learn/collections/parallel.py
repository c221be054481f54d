"""One way to spread work over the shapes of a collection."""

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import TypeVar

from joblib import Parallel, cpu_count, delayed, parallel_config
from threadpoolctl import ThreadpoolController

from lssd_learn.progress import track

T = TypeVar("T")

WORTH = 10.0  # seconds of work from which processes of their own pay for their start


def in_parallel(
    work: Callable[..., T], items: Sequence[int], what: str, workers: int | None, *arguments
) -> Iterator[T]:
    """Yield `work(item, *arguments)` for every item in order, under a progress bar.

    Every item is worked on by one thread, wherever it is: the result does not depend on the number of processes, and
    processes times threads stays the number of cores.

    Args:
        work: a function at the top of a module, with picklable arguments.
        what: a few words for the bar.
        workers: processes; None is one a core, or this one alone where that is done in seconds.
    """
    begun: list[T] = []
    if workers is None:
        # The first may load a model; the second tells how long one takes.
        for i in items[:2]:
            start = time.monotonic()
            begun.append(on_one_thread(work, i, *arguments))
        left = len(items) - len(begun)
        workers = cpu_count() if left and left * (time.monotonic() - start) > WORTH else 1
    rest = items[len(begun) :]
    if workers > 1 and len(rest) > 1:
        with parallel_config(backend="loky", inner_max_num_threads=1):
            results = Parallel(n_jobs=workers, return_as="generator")(delayed(work)(i, *arguments) for i in rest)
            yield from track(chain(begun, results), what, len(items))
    else:
        results = (on_one_thread(work, i, *arguments) for i in rest)
        yield from track(chain(begun, results), what, len(items))


def on_one_thread(work: Callable[..., T], *arguments) -> T:
    """`work(*arguments)`, its linear algebra on one thread."""
    with ThreadpoolController().limit(limits=1):
        return work(*arguments)
