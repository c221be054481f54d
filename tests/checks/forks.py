"""Processes of the program that have nothing left to import: each is forked from one that has done so once.

To import torch and Lightning takes a process about four seconds, more than most tests ask it to do afterwards. What is
forked is a process like any other, with arguments, folder, environment and streams of its own, and it ends as Python
ends. Run as a script this file is the process that forks.
"""

import json
import os
import runpy
import subprocess
import sys
import tempfile
from importlib import import_module, invalidate_caches
from pathlib import Path

# What train.py imports itself before it does anything.
BEFOREHAND = ("lssd_learn.app", "lssd_learn.tasks.regression")


class Forks:
    """A context: `run` forks one process and waits for its end.

    Args:
        folder: for the streams of what is forked.
        options: of Python itself, such as ("-W", "error").
    """

    def __init__(self, folder, options=()):
        self.folder, self.options, self._from = folder, options, None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._from is not None:
            self._from.stdin.close()
            self._from.wait()
            self._from.stdout.close()

    def run(self, arguments, cwd, env, code=None):
        """A finished process, as of subprocess.run: of a script and its arguments, or of code that reads sys.argv."""
        if self._from is None:
            line = [sys.executable, *self.options, __file__]
            env_here = {**os.environ, "OMP_NUM_THREADS": "1"}
            pipe = subprocess.PIPE
            self._from = subprocess.Popen(line, env=env_here, stdin=pipe, stdout=pipe, text=True)
        streams = [Path(tempfile.mkstemp(dir=self.folder, suffix=name)[1]) for name in (".out", ".err")]
        asked = {"arguments": [*map(str, arguments)], "cwd": str(cwd), "env": dict(env), "code": code}
        print(json.dumps(asked | {"streams": [*map(str, streams)]}), file=self._from.stdin, flush=True)
        answer = self._from.stdout.readline()
        assert answer, "the process that forks has ended"
        return subprocess.CompletedProcess(asked["arguments"], int(answer), *(stream.read_text() for stream in streams))


def _become(asked):
    """Turn this process, just forked, into the one that is asked for."""
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["env"])
    own = list(filter(None, asked["env"].get("PYTHONPATH", "").split(os.pathsep)))
    sys.path[:] = [*own, *(path for path in sys.path if path not in own)]
    invalidate_caches()
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for number, stream in zip((1, 2), asked["streams"], strict=True):
        os.dup2(os.open(stream, os.O_WRONLY | os.O_TRUNC), number)
    sys.argv = asked["arguments"]


def _serve():
    """Fork for every line of standard input, and say how each ended; returns in what is forked alone."""
    while line := sys.stdin.readline():
        pid = os.fork()
        if pid == 0:
            return json.loads(line)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)
    sys.exit()


if __name__ == "__main__":
    sys.path.pop(0)  # this folder, which a script of the program would not see
    for name in BEFOREHAND:
        import_module(name)
    asked = _serve()
    _become(asked)
    if asked["code"] is None:
        runpy.run_path(sys.argv[0], run_name="__main__")
    else:
        exec(compile(asked["code"], "<code>", "exec"), {"__name__": "__main__"})
