"""Processes of Python that begin where the program's imports are done.

To import torch, Lightning and Hydra costs every process five seconds, and tests that run the program a hundred times
would do little else. One process imports them and is forked for every run; what it does from there on, with arguments,
environment, working directory, files and exit status of its own, is what any process would do.
"""

import json
import os
import runpy
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

IMPORTED = ("app", "learning", "models", "tasks.compare", "tasks.regression", "tasks.operators")
COMMAND = [sys.executable, "-W", "error"]


class Programs:
    """Runs Python as `subprocess.run` does, see there; forks only where that is safe."""

    def __init__(self):
        self._server = None

    def run(self, arguments: Sequence[str], cwd: Path, env: dict[str, str]) -> subprocess.CompletedProcess:
        """What a process of python with such arguments, a script's and its own or -c and code, has said in the end."""
        if sys.platform != "linux":
            line = [*COMMAND, *arguments]
            return subprocess.run(line, cwd=cwd, env=env, capture_output=True, text=True, check=False)
        if self._server is None:
            line, pipe = [*COMMAND, __file__], subprocess.PIPE
            one = {**os.environ, "OMP_NUM_THREADS": "1"}  # a fork has no threads but its own
            self._server = subprocess.Popen(line, stdin=pipe, stdout=pipe, text=True, env=one)
        with tempfile.TemporaryDirectory() as folder:
            said = [Path(folder) / name for name in ("out", "err")]
            job = {"arguments": arguments, "cwd": str(cwd), "env": env, "said": [*map(str, said)]}
            self._server.stdin.write(json.dumps(job) + "\n")
            self._server.stdin.flush()
            status = int(self._server.stdout.readline())
            return subprocess.CompletedProcess(arguments, status, *(file.read_text() for file in said))

    def close(self):
        if self._server is not None:
            self._server.communicate()


def serve() -> dict | None:
    """Fork for every job that is asked for. Returns in the fork, with its job, and without one in the end."""
    for line in sys.stdin:
        if (child := os.fork()) == 0:
            return json.loads(line)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    return None


def become(job: dict) -> None:
    """Be the process that was asked for."""
    for number, name in enumerate([os.devnull, *job["said"]]):
        file = os.open(name, os.O_RDONLY if number == 0 else os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(file, number)
        os.close(file)
    os.chdir(job["cwd"])
    os.environ.clear()
    os.environ.update(job["env"])
    script, *arguments = job["arguments"]
    places = [place for place in job["env"].get("PYTHONPATH", "").split(os.pathsep) if place and place not in sys.path]
    sys.path[:] = ["" if script == "-c" else str(Path(script).parent), *places, *sys.path[1:]]
    if script == "-c":
        code, *arguments = arguments
        sys.argv = ["-c", *arguments]
        exec(code, {"__name__": "__main__"})
    else:
        sys.argv = [script, *arguments]
        runpy.run_path(script, run_name="__main__")


if __name__ == "__main__":
    for module in IMPORTED:
        import_module(f"lssd_learn.{module}")
    if (job := serve()) is not None:
        become(job)
