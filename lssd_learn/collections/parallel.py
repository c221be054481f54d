"""One way to spread work over the shapes of a collection."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from joblib import Parallel, delayed, parallel_config

from lssd_learn.progress import track

T = TypeVar("T")


def in_parallel(work: Callable[..., T], items: Sequence[int], what: str, workers: int, *arguments) -> Iterator[T]:
    """Yield `work(item, *arguments)` for every item in order, under a progress bar.

    Args:
        work: a function at the top of a module, with picklable arguments.
        what: a few words for the bar.
        workers: processes; each runs on one thread, so that processes times threads stays the number of cores.
    """
    if workers <= 1 or len(items) < 2:
        yield from track((work(i, *arguments) for i in items), what, len(items))
        return
    with parallel_config(backend="loky", inner_max_num_threads=1):
        jobs = Parallel(n_jobs=workers, return_as="generator")(delayed(work)(i, *arguments) for i in items)
        yield from track(jobs, what, len(items))
