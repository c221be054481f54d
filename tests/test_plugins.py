"""Somebody else's package: collection, difference, net, topology, maps and task of theirs, no file of ours touched."""

import csv
import json
import os
from pathlib import Path

import numpy as np
import pytest

from lssd_learn.app import conf
from lssd_learn.command.overrides import check
from lssd_learn.command.searchpath import named
from lssd_learn.errors import InputError
from lssd_learn.plugins import find_class

TRAIN = Path(__file__).parents[1] / "train.py"

PACKAGE = {
    "theirs/__init__.py": "from theirs import difference\n",
    "theirs/difference.py": """
from lssd_learn.latent.differences import Difference, register


def theirs(seen):
    return seen.Y.mT @ (seen.evals[:, :, None] ** 2 * seen.Y) / seen.spectrum[-1] ** 2


register(Difference("theirs", theirs, constant_is_null=True, tells="more bends"))
""",
    "theirs/eggs.py": """
import numpy as np
import trimesh

from lssd_learn.collections import Collection
from lssd_learn.shapes import Mesh


class Eggs(Collection):
    parameter_names = ("length", "width")

    def __init__(self, n, seed=0, fineness=2):
        self.parameters = np.random.default_rng(seed).uniform(0.8, 1.6, (n, 2))
        self.names = [f"egg_{i}" for i in range(n)]
        self.key = f"eggs-{n}-{seed}-{fineness}"
        self._ball = trimesh.creation.icosphere(fineness)

    def __len__(self):
        return len(self.names)

    def __getitem__(self, i):
        length, width = self.parameters[i]
        x = self._ball.vertices * [1, width, length]
        return Mesh(x * (1 + 0.2 * x[:, 2:]), self._ball.faces)
""",
    "theirs/net.py": """
from torch import nn


class Plain(nn.Module):
    reads = "operators"

    def __init__(self, channels, size, outputs, bias=True):
        super().__init__()
        self.linear = nn.Linear(channels * size * size, outputs, bias)

    def forward(self, operators):
        return self.linear(operators.flatten(1))
""",
    "theirs/others.py": """
from lssd_learn.latent import MapNetwork
from lssd_learn.maps import VertexMaps


class Maps(VertexMaps):
    pass


def ring(bases, maps=None):
    n = len(bases)
    return MapNetwork.from_edges(bases, [(i, (i + 1) % n) for i in range(n)], maps)


def count(pieces, out, times=1):
    return {"counted": times * len(pieces.pipeline.collection)}
""",
    "conf/collection/theirs.yaml": "_target_: theirs.eggs.Eggs\nn: 24\nseed: 0\nfineness: 2\n",
    "conf/net/theirs.yaml": "_target_: theirs.net.Plain\n_partial_: true\nlearning_rate: 0.003\nbias: true\n",
    "conf/network/theirs.yaml": "_target_: theirs.others.ring\n_partial_: true\n",
    "conf/maps/theirs.yaml": "_target_: theirs.others.Maps\n_partial_: true\n",
    "conf/task/theirs.yaml": "_target_: theirs.others.count\n_partial_: true\ntimes: 2\n",
    "conf/experiment/theirs.yaml": """# @package _global_
defaults:
  - override /collection: theirs
  - override /net: theirs
""",
}  # fmt: skip
DISTRIBUTION = {
    "theirs_of_them-1.5.dist-info/METADATA": "Metadata-Version: 2.1\nName: theirs-of-them\nVersion: 1.5\n",
    "theirs_of_them-1.5.dist-info/entry_points.txt": "[lssd_learn.plugins]\ntheirs = theirs\n",
}
SMALL = ("basis.k=16", "latent.size=12", "latent.keep=8", "data.batch=8", "parallel.workers=1")
CHOICES = ("collection=theirs", "net=theirs")


def write(folder, files):
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder of installed packages with theirs in it, its yamls inside, and the entry point."""
    folder = tmp_path_factory.mktemp("site")
    inside = {name if name.startswith("theirs") else f"theirs/{name}": text for name, text in PACKAGE.items()}
    write(folder, inside | DISTRIBUTION)
    return folder


@pytest.fixture(scope="module")
def loose(tmp_path_factory):
    """The same package as plain files, with its yamls beside it and no entry point."""
    folder = tmp_path_factory.mktemp("loose")
    write(folder, PACKAGE)
    return folder


@pytest.fixture(scope="module")
def program(processes, tmp_path_factory):
    """A function (folder of their package, arguments) → what a process of the program said."""
    home = tmp_path_factory.mktemp("home")

    def run(site, *arguments, status=0):
        path = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])
        places = {**os.environ, "PYTHONPATH": path, "LSSD_CACHE": str(home / "cache"), "OMP_NUM_THREADS": "1"}
        done = processes.run([str(TRAIN), *map(str, arguments)], cwd=home, env=places)
        assert done.returncode == status, done.stderr
        return done.stdout + done.stderr

    run.home = home
    return run


@pytest.fixture(scope="module")
def trained(installed, program):
    """The folder of a run on theirs throughout."""
    out = program.home / "trained"
    given = ("task=regression", *CHOICES, "network=theirs", "latent.operators=[area,theirs]", "task.epochs=30")
    program(installed, *given, *SMALL, f"hydra.run.dir={out}")
    return out


def metrics(out):
    return json.loads((out / "metrics.json").read_text())


def test_their_collection_net_topology_and_difference_train(trained):
    assert metrics(trained)["reference/ridge/mse"] < metrics(trained)["reference/mean/mse"]
    provenance = json.loads((trained / "provenance.json").read_text())
    assert provenance["packages"]["theirs-of-them"] == "1.5"


def test_the_checkpoint_is_read_back_and_finds_the_net_by_its_name(trained, installed, program, tmp_path):
    """The configuration names another net; shapes in correspondence, and others that maps are computed to."""
    given = ("task=predict", f"ckpt_path={trained / 'best.ckpt'}", "collection=theirs", "parallel.workers=1")
    program(installed, *given, "task.neighbours=1", f"hydra.run.dir={tmp_path / 'same'}")  # each pushed from itself
    with (tmp_path / "same" / "predictions.csv").open() as stream:
        assert list(csv.DictReader(stream).fieldnames) == ["name", "length", "width", "size", "unlike", "trusted"]
    parts = [metrics(trained)[f"{part}/mse"] for part in ("train", "validation", "test")]
    assert metrics(tmp_path / "same")["test/mse"] == pytest.approx(np.average(parts, weights=[18, 2, 4]), rel=1e-4)
    strange = ("collection.fineness=3", "collection.n=2", "maps=registration", "maps.rounds=2")
    program(installed, *given, *strange, f"hydra.run.dir={tmp_path / 'other'}")
    assert metrics(tmp_path / "other")["shapes"] == 2


def test_their_task_runs_and_its_keys_are_checked(installed, program, tmp_path):
    out = f"hydra.run.dir={tmp_path}"
    program(installed, "task=theirs", "task.times=3", "experiment=theirs", "maps=theirs", out)
    assert metrics(tmp_path) == {"counted": 72}
    told = program(installed, "task=theirs", "task.tims=3", out, status=1)
    assert told == "error: task.tims=3: there is no task.tims; task has times; did you mean times?\n"
    told = program(installed, "latent.operators=[arae]", "collection=theirs", *SMALL, out, status=1)
    assert "expected some of area, conformal, extrinsic, theirs, each once" in told
    assert "theirs" in program(installed, "--help").split("Of plug-ins, as task=…")[1].split("Other choices")[0]


@pytest.mark.parametrize("where", ["--config-dir", "hydra.searchpath"])
def test_yamls_of_a_folder_are_checked_as_ours_are(loose, where):
    folder = str(loose / "conf")
    there = ["--config-dir", folder] if where == "--config-dir" else [f"hydra.searchpath=['file://{folder}']"]
    check([*there, "experiment=theirs", "task=theirs", "collection.n=3", "net.bias=false"], conf())
    with pytest.raises(InputError, match="^collection.m=3: there is no collection.m; collection has n, seed,"):
        check([*there, "collection=theirs", "collection.m=3"], conf())
    with pytest.raises(
        InputError, match=r"^net=their: expected one of autoencoder, .*or, theirs, vertices; did you mean theirs\?$"
    ):
        check([*there, "net=their"], conf())
    with pytest.raises(InputError, match="^net=theirs: expected one of"):
        check(["net=theirs"], conf())


def test_a_file_names_no_code_of_packages_that_nobody_named(trained, loose, program, tmp_path):
    """Not installed, and neither collection nor net of the configuration in use are theirs: refused by name."""
    given = ("task=predict", f"ckpt_path={trained / 'best.ckpt'}", f"hydra.run.dir={tmp_path}")
    told = program(loose, *given, "collection=bumps", status=1)
    assert "its net is theirs.net.Plain, but theirs is no plug-in of lssd_learn, and a file shall not name code" in told
    told = program(loose, "--config-dir", loose / "conf", *given, "collection=theirs", "parallel.workers=1")
    assert "2 parameters of 24 shapes" in told


def test_a_plug_in_that_cannot_be_imported_is_named(tmp_path, program):
    write(tmp_path, {**DISTRIBUTION, "theirs/__init__.py": "import nothing_like_it\n"})
    told = program(tmp_path, "--cfg", "job", status=1)
    assert told == (
        "error: plug-in theirs: theirs cannot be imported: ModuleNotFoundError: No module named 'nothing_like_it'\n"
    )


def test_what_the_command_line_adds_to_the_search_path():
    assert named(["--config-dir", "/a", "seed=1", "hydra.searchpath=[/b,pkg://c]"]) == ["/a", "/b", "pkg://c"]
    assert named(["--config-dir=/a"]) == ["/a"]
    for place in ("/nowhere/at/all", "pkg://nowhere.at_all"):
        with pytest.raises(InputError, match=f"^{place}: expected a folder of the configuration"):
            check([f"hydra.searchpath=['{place}']"], conf())


@pytest.mark.parametrize("path", ["os.system", "sys.modules", "torch.nn.Linear", "theirs.Net", "nothing"])
def test_classes_of_strangers_are_not_looked_up(path):
    with pytest.raises(InputError, match=rf"^x: {path}, but {path.split('.')[0]} is no plug-in of lssd_learn"):
        find_class(path, object, "x:")


@pytest.mark.parametrize(
    "path", ["lssd_learn.cache.store.Path", "lssd_learn.cache.store.os.system", "lssd_learn.pipeline.log"]
)
def test_what_a_module_of_ours_has_imported_is_not_ours(path):
    with pytest.raises(InputError, match=rf"^x: {path}"):
        find_class(path, object, "x:")
