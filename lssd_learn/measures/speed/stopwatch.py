"""Seconds and peak memory of a piece of work, each in a process of its own, so that nothing else is counted.

The work is a generator function: what it does before its first `yield` warms up and is not timed, every `yield "name"`
starts a lap, `yield None` stops the clock, and what it returns after that comes back as the result:

    def work(bases):
        import torch                    # not timed
        yield "fit"
        space = fit(bases)              # timed
        yield None
        return space.spectrum           # not timed
"""

import os
import pickle
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lssd_learn.errors import InputError

Work = Callable[[], Generator[str | None, None, Any]]

SAMPLING = 0.02  # seconds between two looks at the memory
THREAD_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class WorkFailedError(RuntimeError):
    """The process ended without a result: an error of its own, or the system took it away, often for its memory."""


@dataclass(frozen=True)
class Measured:
    """What one piece of work took.

    Attributes:
        laps: name → seconds, in order, on the clock that was asked for.
        megabytes: peak anonymous resident memory of the whole process while the clock ran, in 10⁶ bytes: interpreter,
            libraries and inputs are in it, memory-mapped files are not. Where there is no /proc, the peak of
            everything resident since the process began.
        result: what the work returned.
    """

    laps: dict[str, float]
    megabytes: float
    result: Any = None

    @property
    def seconds(self) -> float:
        """The sum of the laps."""
        return sum(self.laps.values())

    @property
    def median(self) -> float:
        """The median of the laps, in seconds: of work that repeats itself."""
        return statistics.median(self.laps.values())


def measure(work: Work, threads: int = 1, processor: bool = False) -> Measured:
    """Do `work` in a fresh process that computes with so many threads.

    Args:
        work: a generator function at the top of a module, or a `functools.partial` of one; see above.
        threads: of BLAS, OpenMP and torch.
        processor: count the seconds that the processor worked for that process, all threads together and none of its
            children, instead of those that passed: whatever else the machine does is then left out.

    Raises:
        InputError: the work raised it.
        WorkFailedError: the process ended without a result.
    """
    with TemporaryDirectory() as folder:
        question, answer, said = (Path(folder) / name for name in ("question", "answer", "said"))
        question.write_bytes(pickle.dumps((work, processor)))
        command = [sys.executable, "-m", "lssd_learn.measures.speed.stopwatch", str(question), str(answer)]
        with said.open("wb") as stderr:
            child = subprocess.Popen(command, env=_environment(threads), stdout=subprocess.DEVNULL, stderr=stderr)
            try:
                samples = _watch(child)
            finally:  # an interrupted run leaves no process behind
                child.kill()
                child.wait()
        if not answer.exists():
            told = said.read_text(errors="replace").strip().splitlines()
            raise WorkFailedError(f"exit status {child.returncode}: {told[-1] if told else 'the process was killed'}")
        got = pickle.loads(answer.read_bytes())
    if "refused" in got:
        raise InputError(got["refused"])
    first, last = got["clock"]
    memory = [got["memory"], *(size for moment, size in samples if first <= moment <= last)]
    return Measured(got["laps"], max(memory) / 1e6, got["result"])


def _environment(threads: int) -> dict[str, str]:
    # The child finds what this process finds, whatever made it findable.
    paths = os.pathsep.join(path for path in sys.path if path)
    return {**os.environ, "PYTHONPATH": paths, **dict.fromkeys(THREAD_SETTINGS, str(threads))}


def _watch(child: subprocess.Popen) -> list[tuple[float, int]]:
    """(moment, bytes) of the child's memory until it ends. Seen from outside: a thread inside would have to wait for
    libraries that hold the interpreter's lock, and would take time from the work."""
    samples = []
    while child.poll() is None:
        samples.append((time.monotonic(), _anonymous(child.pid)))
        time.sleep(SAMPLING)
    return samples


def _anonymous(process: int | str) -> int:
    """Anonymous resident memory of a process in bytes; 0 where the system does not say."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0
    sizes = [line.split()[1] for line in status.splitlines() if line.startswith("RssAnon")]
    return int(sizes[0]) * 1024 if sizes else 0


def _highest() -> int:
    """The peak of the resident memory of this process in bytes, where there is no /proc."""
    import resource  # not on Windows

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _timed(work: Work, processor: bool) -> dict[str, Any]:
    """Run the generator with the clock: its laps, the moments between which it ran, memory seen at their ends."""
    now = time.process_time if processor else time.perf_counter
    steps = work()
    lap = next(steps)
    laps, memory, begun = {}, _anonymous("self"), time.monotonic()
    while lap is not None:
        start = now()
        following = next(steps)
        laps[lap] = now() - start
        memory, lap = max(memory, _anonymous("self")), following
    clock = (begun, time.monotonic())
    try:
        next(steps)
    except StopIteration as end:
        return {"laps": laps, "clock": clock, "memory": memory or _highest(), "result": end.value}
    raise RuntimeError("the work went on after it had stopped the clock")


def _main(question: str, answer: str) -> None:
    work, processor = pickle.loads(Path(question).read_bytes())
    try:
        got = _timed(work, processor)
    except InputError as error:
        got = {"refused": str(error)}
    Path(answer).write_bytes(pickle.dumps(got))


if __name__ == "__main__":
    _main(*sys.argv[1:])
