"""A folder has one run at a time, and one that is named after the moment is nobody else's."""

import subprocess
import sys
import threading

import pytest

from lssd_learn.command import claims
from lssd_learn.command.claims import CLAIM, claim, claim_new
from lssd_learn.errors import InputError

HOLD = """
import sys
from pathlib import Path
from lssd_learn.command.claims import claim
claim(Path(sys.argv[1]), "hydra.run.dir")
print("taken", flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _nothing_held(monkeypatch):
    monkeypatch.setattr(claims, "_held", {})


@pytest.fixture
def holder(tmp_path):
    """Another process that has the folder `taken`."""
    line = [sys.executable, "-c", HOLD, str(tmp_path / "taken")]
    with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "taken\n"
        yield process
        process.kill()


def test_the_folder_of_a_run_that_is_alive_is_refused_and_free_when_it_has_ended(holder, tmp_path):
    with pytest.raises(InputError, match=r"hydra.run.dir=.*taken: another run is at work in this folder"):
        claim(tmp_path / "taken", "hydra.run.dir")
    assert {path.name for path in (tmp_path / "taken").iterdir()} == {CLAIM}
    holder.kill()
    holder.wait()
    claim(tmp_path / "taken", "hydra.run.dir")
    claim(tmp_path / "taken", "hydra.run.dir")  # its own is no obstacle


def test_folders_of_one_second_are_all_different(tmp_path):
    begin, made = threading.Barrier(8), []

    def take():
        begin.wait()
        made.append(claim_new(tmp_path / "a" / "12-00-00", "hydra.run.dir"))

    threads = [threading.Thread(target=take) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    names = ["12-00-00", *(f"12-00-00_{i}" for i in range(2, 9))]
    assert sorted(path.name for path in made) == sorted(names)
