"""The store of arrays among processes: kills, leftovers, and several that want the same entry."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np

import lssd_learn
from lssd_learn.cache import fingerprint


def python(code, *arguments):
    """A Python process that runs `code` on this package."""
    path = os.pathsep.join([str(Path(lssd_learn.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_fingerprint_is_the_same_in_another_process():
    other = python("from lssd_learn.cache import fingerprint; print(fingerprint('a', 1, {'b': None}))")
    assert other.communicate()[0].strip() == fingerprint("a", 1, {"b": None})


KILLED = """
    import os, signal, sys
    import numpy as np
    from lssd_learn.cache import Cache, fingerprint

    class Arrays(dict):
        def items(self):
            yield "first", np.arange(2000)  # more than a stream holds back
            os.kill(os.getpid(), signal.SIGKILL)

    Cache(sys.argv[1]).get("s", "k", Arrays)
"""


def test_a_run_killed_while_it_writes_leaves_nothing_half_made(cache):
    process = python(KILLED, cache.root)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    (draft,) = (cache.root / "s" / "k").glob("*.draft")
    assert draft.stat().st_size >= 8000
    assert cache.load("s", "k") is None
    assert not cache.path("s", "k").exists()
    # The next run is not held up, makes the entry whole and takes the draft away.
    assert cache.get("s", "k", lambda: {"first": np.arange(3)})["first"].tolist() == [0, 1, 2]
    assert [p.name for p in (cache.root / "s" / "k").iterdir()] == ["k.arrays"]


def test_a_draft_of_another_entry_is_left_alone(cache):
    other, mine = (cache.path("s", key).with_suffix(".draft") for key in ("kother", "k"))
    for draft in (other, mine):
        draft.parent.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(b"half")
    cache.get("s", "k", lambda: {"x": np.ones(1)})
    assert other.exists()
    assert not mine.exists()


def test_to_write_an_entry_lists_no_stage(cache, monkeypatch):
    """A stage of 100,000 entries takes no longer than one of a thousand."""
    cache.get("s", "first", lambda: {"x": np.ones(1)})
    stage, listed = cache.root / "s", []
    for name in ("listdir", "scandir"):
        real = getattr(os, name)
        monkeypatch.setattr(os, name, lambda path=".", real=real: listed.append(Path(str(path))) or real(path))
    cache.get("s", "k", lambda: {"x": np.ones(1)})
    assert stage not in listed


COUNTED = """
    import sys, time
    import numpy as np
    from lssd_learn.cache import Cache, fingerprint

    root, log, ready = sys.argv[1:]

    def make():
        with open(log, "a") as stream:
            stream.write("made\\n")
        time.sleep(0.5)
        return {"x": np.arange(5)}

    cache = Cache(root)
    open(ready, "w").close()
    print(cache.get("s", "k", make)["x"].sum())
"""


def test_processes_that_want_the_same_entry_make_it_once(cache, tmp_path):
    log = tmp_path / "log"
    processes = [python(COUNTED, cache.root, log, tmp_path / f"ready{i}") for i in range(2)]
    outputs = [process.communicate(timeout=60) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    assert [out.strip() for out, _ in outputs] == ["10", "10"]
    assert log.read_text() == "made\n"
