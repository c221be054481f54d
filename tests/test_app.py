"""The program as a person runs it: small bodies, real steps, one process a command."""

import json
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch

from lssd_learn.collections import POSE_NAMES
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.storage import read_checkpoint
from lssd_learn.learning import Classification, load
from lssd_learn.nets import CNN

TRAIN = Path(__file__).parents[1] / "train.py"


@pytest.fixture(scope="session")
def program(processes, tmp_path_factory):
    """A function that runs train.py on one cache and gives the finished process.

    With `warnings` it is a process from its first line on, and not a fork of one that has imported the program. `start`
    gives one that runs, `python` the process of any other arguments of python.
    """
    home = tmp_path_factory.mktemp("program")
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "LSSD_CACHE": str(home / "cache")}

    def python(*arguments):
        return processes.run(arguments, cwd=home, env=environment)

    def run(*arguments, status=0, cache="cache", warnings=None):
        line, places = [str(TRAIN), *map(str, arguments)], {**environment, "LSSD_CACHE": str(home / cache)}
        if warnings is None:
            done = processes.run(line, cwd=home, env=places)
        else:
            line = [sys.executable, "-W", warnings, *line]
            done = subprocess.run(line, cwd=home, env=places, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stderr
        return done

    def start(*arguments):
        line = [sys.executable, str(TRAIN), *map(str, arguments)]
        return subprocess.Popen(line, cwd=home, env=environment, stderr=subprocess.DEVNULL)

    run.start, run.python, run.home = start, python, home
    return run


@pytest.fixture(scope="session")
def first(program, tmp_path_factory):
    """The folder of a first, uninterrupted run of six epochs."""
    out = tmp_path_factory.mktemp("first")
    program("debug=fast", "debug.epochs=6", f"hydra.run.dir={out}", warnings="error")
    return out


def metrics(out):
    return json.loads((out / "metrics.json").read_text())


def test_a_run_leaves_what_it_promises(first):
    numbers = metrics(first)
    for name in ("test/mse", "test/l1", "train/mse", "generalisation_error", "best_epoch", "seconds/fit"):
        assert np.isfinite(numbers[name])
    for reference in ("mean", "ridge"):
        assert 0 < numbers[f"reference/{reference}/mse"] < 0.2
    assert numbers["reference/ridge/mse"] < numbers["reference/mean/mse"]
    provenance = json.loads((first / "provenance.json").read_text())
    assert set(provenance["keys"]) == {"collection", "eigenbases", "latent"}
    assert provenance["packages"]["torch"]
    assert {"best.ckpt", "last.ckpt", "tensorboard", ".hydra", "run.log"} <= {path.name for path in first.iterdir()}
    assert load(first / "best.ckpt", CNN).net is not None


def test_the_second_run_computes_nothing_geometric_and_loads_no_body_model(program, first, tmp_path):
    done = program("debug=fast", "net=mlp", "task.epochs=1", f"hydra.run.dir={tmp_path}")
    assert "eigenbases" not in done.stderr
    assert "network of" not in done.stderr
    # Neither anny nor the body model can be imported here, and nothing misses them.
    code = (
        "import sys, runpy; sys.modules['anny'] = None; sys.modules['roma'] = None;"
        f"sys.argv = ['train.py', 'debug=fast', 'net=mlp', 'task.epochs=1', 'hydra.run.dir={tmp_path / 'blind'}'];"
        f"runpy.run_path({str(TRAIN)!r}, run_name='__main__')"
    )
    blind = program.python("-c", code)
    assert blind.returncode == 0, blind.stderr


@pytest.mark.slow
def test_the_command_of_the_provenance_gives_the_same_bits_with_a_cold_cache_and_one_worker(program, first, tmp_path):
    provenance = json.loads((first / "provenance.json").read_text())
    python, script, *arguments = shlex.split(provenance["command"])
    assert (python, script) == ("python", "train.py")
    program(*arguments, "parallel.workers=1", f"hydra.run.dir={tmp_path}", cache="cold")
    expected, got = metrics(first), metrics(tmp_path)
    for name in expected:
        assert got[name] == expected[name] or "seconds" in name, name
    again = json.loads((tmp_path / "provenance.json").read_text())
    assert (again["keys"], again["packages"]) == (provenance["keys"], provenance["packages"])


@pytest.mark.slow
def test_two_processes_train_as_one_and_their_sweep_leaves_no_stray_folders(program, first, tmp_path):
    """Distributed data parallel training on two CPU processes, each with half of every batch."""
    before = set(program.home.rglob("multirun*")) | set(program.home.rglob("outputs*"))
    sweep = tmp_path / "sweep"
    arguments = ["debug=fast", "debug.epochs=6", "trainer=ddp", "seed=0,1", f"hydra.sweep.dir={sweep}"]
    program("-m", *arguments, warnings="default")
    expected, got = metrics(first), metrics(sweep / "0")
    assert set(got) == set(expected)
    assert got["best_epoch"] == expected["best_epoch"]
    for name in ("test/mse", "test/l1", "validation/mse"):
        assert got[name] == pytest.approx(expected[name], rel=1e-3)  # sums in another order
    names = [
        sorted(str(p.relative_to(out)) for p in out.rglob("*") if p.name != ".claim") for out in (first, sweep / "0")
    ]
    assert [n for n in names[0] if "tfevents" not in n] == [n for n in names[1] if "tfevents" not in n]
    assert len(names[0]) == len(names[1])
    left = sorted(path.name for path in sweep.iterdir() if path.name != ".claim")
    assert left == ["0", "1", "multirun.yaml", "summary.csv", "summary.md", "summary.png"]
    assert [path.name for path in tmp_path.iterdir()] == ["sweep"]
    assert set(program.home.rglob("multirun*")) | set(program.home.rglob("outputs*")) == before


def test_poses_are_classified_and_the_checkpoint_knows_their_names(program, first, tmp_path):
    done = program("debug=fast", "task=classification", "task.group=pose", f"hydra.run.dir={tmp_path}")
    assert "linear on the operators" in done.stderr
    numbers = metrics(tmp_path)
    for name in ("test/accuracy", "test/cross_entropy", "reference/linear/accuracy", "reference/majority/accuracy"):
        assert np.isfinite(numbers[name])
    assert numbers["reference/linear/accuracy"] > numbers["reference/majority/accuracy"]
    checkpoint = read_checkpoint(tmp_path / "best.ckpt")
    assert (checkpoint["group"], checkpoint["classes"]) == ("pose", sorted(POSE_NAMES))
    assert load(tmp_path / "best.ckpt", CNN, Classification)(torch.zeros(1, 1, 20, 20)).shape == (1, 8)


def test_a_killed_run_goes_on_and_ends_with_the_metrics_of_an_uninterrupted_one(program, first, tmp_path):
    arguments = ["debug=fast", "debug.epochs=30"]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    program(*arguments, f"hydra.run.dir={whole}")
    process = program.start(*arguments, f"hydra.run.dir={killed}")
    while process.poll() is None and not (killed / "last.ckpt").exists():
        time.sleep(0.01)
    process.kill()
    process.wait()
    assert not (killed / "metrics.json").exists()
    program(*arguments, f"hydra.run.dir={killed}", "ckpt_path=last")
    expected, got = metrics(whole), metrics(killed)
    for name in expected:
        assert got[name] == expected[name] or "seconds" in name, name


def test_a_failed_run_says_why_until_it_is_done_again(program, first, tmp_path):
    program("debug=fast", "latent.keep=99", f"hydra.run.dir={tmp_path}", status=1)
    assert (tmp_path / "error.txt").read_text() == (
        "latent.keep=99: expected 1 to size=24, but here basis.k=30 latent.size=24 latent.keep=99\n"
    )
    program("debug=fast", "debug.epochs=1", f"hydra.run.dir={tmp_path}")
    assert not (tmp_path / "error.txt").exists()


def test_a_sweep_without_a_folder_of_its_own_gets_one_named_after_its_task(program, first):
    done = program("-m", "task=summary", f"task.folder={first}")
    (out,) = [line.split()[-1] for line in done.stderr.splitlines() if line.startswith("everything is in")]
    assert Path(out).parts[-4:-2] == ("multirun", "summary")
    assert Path(out).name == "0"


def test_a_sweep_goes_over_nets_seeds_and_functions_and_survives_a_wrong_job(program, first, tmp_path):
    done = program(
        "-m",
        "debug=fast",
        "debug.epochs=1",
        "net=cnn,pointnet",
        "latent.keep=10,99",
        f"hydra.sweep.dir={tmp_path}",
        status=1,
    )
    assert "latent.keep=99: expected 1 to size=24" in done.stderr
    assert "Traceback" not in done.stderr
    assert [(tmp_path / str(job) / "metrics.json").is_file() for job in range(4)] == [True, False, True, False]
    summary = (tmp_path / "summary.md").read_text()
    assert summary.rstrip() in done.stderr
    assert "- 1 debug=fast debug.epochs=1 net=cnn latent.keep=99: latent.keep=99: expected 1 to size=24, but" in summary
    files = {name: tmp_path / f"summary.{name}" for name in ("csv", "md", "png")}
    for file in files.values():
        file.unlink()
    program("task=summary", f"task.folder={tmp_path}", f"hydra.run.dir={tmp_path / 'again'}")
    assert all(file.is_file() for file in files.values())
    assert files["md"].read_text() == summary


@pytest.mark.parametrize("launcher", ["joblib", "submitit_local", "ray"])
def test_jobs_in_processes_of_their_own_are_summed_up_too(program, first, tmp_path, launcher):
    pytest.importorskip(f"hydra_plugins.hydra_{launcher.split('_')[0]}_launcher")
    done = program(
        "-m", f"parallel={launcher}", "debug=fast", "debug.epochs=1", "latent.keep=10,99", "seed=0,1",
        f"hydra.sweep.dir={tmp_path}", status=1,
    )  # fmt: skip
    assert "2 failed:" in done.stderr
    assert "latent.keep=99: expected 1 to size=24" in done.stderr
    assert "| 10 | 2 | 0 |" in (tmp_path / "summary.md").read_text()


def test_a_search_leaves_its_best_and_a_summary(program, first, tmp_path):
    pytest.importorskip("hydra_plugins.hydra_optuna_sweeper")
    program(
        "experiment=optuna", "debug=fast", "debug.epochs=1", "latent.keep=20", "hydra.sweeper.n_trials=2",
        f"hydra.sweep.dir={tmp_path}", warnings="default",  # of an optuna and an SQLAlchemy that are years old
    )  # fmt: skip
    assert "net.learning_rate" in (tmp_path / "optimization_results.yaml").read_text()
    assert "| net.learning_rate | " in (tmp_path / "summary.md").read_text()


def test_operators_of_a_folder_are_written_and_can_be_loaded(program, small_mesh_folder, tmp_path):
    out = tmp_path / "out"
    done = program(
        "task=operators", "collection=folder", f"collection.path={small_mesh_folder}", "network=chain", "basis.k=12",
        "latent.size=10", "latent.keep=8", f"hydra.run.dir={out}",
    )  # fmt: skip
    assert "latent spectrum: 0 " in done.stderr
    assert "in pictures y points up; collection.up=z where it is z" in done.stderr
    arrays = np.load(out / "operators.npz")
    assert arrays["area"].shape == (5, 8, 8)
    np.testing.assert_allclose(arrays["area"].mean(0), np.eye(8), atol=1e-10)
    assert LatentSpace.load(out / "latent.npz").keep == 8
    header, *rows = (out / "shape_variables.csv").read_text().splitlines()
    assert header.split(",")[:3] == ["name", "area_1_1", "area_1_2"]
    assert [row.split(",")[0] for row in rows] == arrays["names"].tolist()
    assert all(row.count(",") == 8 * 9 / 2 for row in [header, *rows])
    for picture in ("spectrum.png", "pca.png"):
        assert (out / picture).stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ckpt_path=last"], "ckpt_path=last: expected a checkpoint"),
        (["net=cn"], "net=cn: expected one of"),
    ],
)
def test_a_mistake_is_one_line_and_exit_status_1(program, first, arguments, message, tmp_path):
    done = program("debug=fast", *arguments, f"hydra.run.dir={tmp_path}", status=1)
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert len([line for line in done.stderr.splitlines() if "error" in line]) == 1


def test_a_missing_eigenbasis_names_a_command_that_makes_it_again(program, first):
    space = LatentSpace.load(first / "best.ckpt")
    remedy = space.bases.remedy
    assert remedy.startswith("python train.py debug=fast")
    assert remedy.endswith("task=operators")


def test_the_remedy_keeps_the_network_and_drops_the_net(program, first, tmp_path):
    program("debug=fast", "network=star", "net=mlp", "debug.epochs=1", f"hydra.run.dir={tmp_path}")
    remedy = LatentSpace.load(tmp_path / "best.ckpt").bases.remedy
    assert "network=star" in remedy
    assert "net=mlp" not in remedy


def test_a_fault_of_the_program_keeps_its_traceback(program, tmp_path):
    code = (
        "import sys, lssd_learn.collections as c;"
        "c.Bodies.__init__ = lambda *a, **k: 1 / 0;"
        f"sys.argv = ['train.py', 'debug=fast', 'hydra.run.dir={tmp_path}'];"
        "from lssd_learn.app import main; main()"
    )
    done = program.python("-c", code)
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr
    assert "Traceback" in done.stderr
