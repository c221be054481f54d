"""One way to spread work over the shapes of a collection."""

import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import lru_cache
from itertools import chain
from typing import Any, TypeVar, cast

from joblib import Parallel, cpu_count, delayed, effective_n_jobs, parallel_config
from joblib.externals.loky.backend import resource_tracker
from joblib.parallel import get_active_backend
from threadpoolctl import ThreadpoolController

from lssd_learn.cluster import is_on_cluster
from lssd_learn.progress import track

T = TypeVar("T")

WORTH = 10.0  # seconds of work from which processes of their own pay for their start
ROUND = 64  # items after which progress is shown where a backend does not show it by itself; at most one piece of work
SHARES = 16  # pieces of work a process at least, where there are as many items: none waits long for the others


def in_parallel(
    work: Callable[..., T], items: Sequence[int], what: str, workers: int | None, *arguments
) -> Iterator[T]:
    """Yield `work(item, *arguments)` for every item in order, under a progress bar.

    Every item is worked on by one thread, wherever it is: the result does not depend on the number of processes, and
    processes times threads stays the number of cores. Inside `cluster`, or a joblib.parallel_config of one's own, the
    processes are those of the cluster.

    Args:
        work: a function at the top of a module, with picklable arguments.
        what: a few words for the bar.
        workers: processes of this machine; None is one a core, or this one alone where that is done in seconds. The
            size of a cluster is its own business.
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
        with nullcontext() if is_on_cluster() else parallel_config(backend="loky", inner_max_num_threads=1):
            results = _spread(work, rest, -1 if is_on_cluster() else workers, arguments)
            yield from track(chain(begun, results), what, len(items))
    else:
        results = (on_one_thread(work, i, *arguments) for i in rest)
        yield from track(chain(begun, results), what, len(items))


def _spread(work: Callable[..., T], items: Sequence[int], processes: int, arguments: tuple) -> Iterator[T]:
    """The results as they come, in order; from a backend that only gives all at once, some by some.

    The arguments travel with every piece of work, and a collection grows with its shapes: of many, several shapes are
    one piece, up to `ROUND`.
    """
    streams = cast(Any, get_active_backend()[0]).supports_return_generator
    parallel = Parallel(n_jobs=processes, return_as="generator" if streams else "list")
    # Workers that have grown by .3 GB, as by the model of bodies, are replaced, and the rest goes on. The warning of it
    # comes from the thread that replaces them: where warnings are errors that one dies, and nobody hears of the rest.
    warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
    size = max(1, min(ROUND, len(items) // (SHARES * max(1, effective_n_jobs(processes)))))
    pieces = [items[begin : begin + size] for begin in range(0, len(items), size)]
    step = len(pieces) if streams else max(1, ROUND // size)
    for begin in range(0, len(pieces), step):
        with _without_interrupts():
            some = parallel(delayed(_several)(work, piece, *arguments) for piece in pieces[begin : begin + step])
        yield from chain.from_iterable(cast(Iterable[list[T]], some))


def _several(work: Callable[..., T], items: Sequence[int], *arguments) -> list[T]:
    return [on_one_thread(work, i, *arguments) for i in items]


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Processes that start inside never hear of Ctrl-C, which goes to all of a terminal's: this one ends them.

    A signal that comes meanwhile waits.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    from multiprocessing import resource_tracker as ours

    for tracker in (ours, resource_tracker):
        tracker.ensure_running()  # whose own start would let the signal through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def on_one_thread(work: Callable[..., T], *arguments) -> T:
    """`work(*arguments)`, its linear algebra on one thread."""
    with _libraries(len(sys.modules)).limit(limits=1):
        return work(*arguments)


@lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:
    """Those with threads of their own. To look for them takes two milliseconds, as long as much of the work: they are
    looked for again where more `modules` have been imported, which may have brought some."""
    return ThreadpoolController()
