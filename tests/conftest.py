"""What several rooms test on: small bodies, whose eigenbases are computed once a session."""

import os

# The tests compute on small matrices, for which the threads of BLAS do little but wait for each other, and waiting is
# as busy as work. So do the processes that tests begin, and all libraries that are loaded from here on.
os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import json
import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import programs
import pytest
import shape_checks  # noqa: F401  before anything of the package, whose signatures hold from here on
import torch
import trimesh
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import OmegaConf
from threadpoolctl import threadpool_limits

from lssd_learn.app import conf
from lssd_learn.cache import Cache
from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh, eigenbasis, save

TESTS = Path(__file__).parent

threadpool_limits(1)  # and those that plug-ins of pytest have loaded before


# Begun before all others, the longest first: nothing that takes a minute is left to one worker at the end. The very
# first builds the body model, which others would wait for; the rooms after it need none.
FIRST = ("collections/generated/test_bodies.py", "shapes", "view", "nets/test_c", "command", "test_app.py",
    "test_plugins.py", "test_notebook.py", "measures", "models", "tasks", "maps")  # fmt: skip


def pytest_collection_modifyitems(items):
    def rank(item):
        name = item.path.relative_to(TESTS).as_posix()
        return next((place for place, first in enumerate(FIRST) if name.startswith(first)), len(FIRST))

    items.sort(key=rank)


@pytest.fixture(autouse=True)
def _one_thread():
    """Small matrices are fastest on one thread, and results do not depend on how many cores there are."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="session")
def processes():
    """What runs Python in processes that have imported the program, see `checks/programs.py`."""
    started = programs.Programs()
    yield started
    started.close()


@pytest.fixture(scope="session")
def body_meshes():
    """120 bodies of 615 vertices."""
    return list(Bodies(n=120, topology="notoes_collapse5pc"))


class Bases(Sequence):
    """Eigenbases of 80 functions of some meshes. Each is made when first asked for, by one of the test processes."""

    def __init__(self, meshes, folder):
        self.meshes, self.folder, self.known = meshes, folder, {}

    def __len__(self):
        return len(self.meshes)

    def __getitem__(self, i):
        if isinstance(i, slice):
            return [self[j] for j in range(len(self))[i]]
        i = range(len(self))[i]
        if i not in self.known:
            file = self.folder / f"basis_{i}.pickle"
            if not file.exists():
                draft = self.folder / f"basis_{i}.{os.getpid()}"
                draft.write_bytes(pickle.dumps(eigenbasis(self.meshes[i], 80)))
                draft.replace(file)
            self.known[i] = pickle.loads(file.read_bytes())
        return self.known[i]


@pytest.fixture(scope="session")
def common_folder(tmp_path_factory):
    """A folder of all test processes, empty when the first of them begins."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session")
def common_cache(common_folder):
    """The folder of a cache for runs on the same bodies of which none has to be the first."""
    return common_folder / "common_cache"


@pytest.fixture(scope="session")
def many_bodies(body_meshes, common_folder):
    """Their eigenbases of 80 functions, float64; a slice of it is a list of those it needs."""
    return Bases(body_meshes, common_folder)


@pytest.fixture(scope="session")
def body_bases(many_bodies):
    """The first 24 of them."""
    return many_bodies[:24]


@pytest.fixture(scope="session")
def truncated(many_bodies):
    """A function (n, k) → the first n bodies with k eigenfunctions."""
    return lambda n, k: [basis.truncate(k) for basis in many_bodies[:n]]


@pytest.fixture(scope="session")
def deformed_spheres():
    """A function (n, subdivisions) → n smooth deformations of an icosphere, one connectivity."""

    def make(n, subdivisions, seed=0):
        sphere = trimesh.creation.icosphere(subdivisions)
        x = np.array(sphere.vertices)
        rng = np.random.default_rng(seed)
        linear, waves, phases = (rng.normal(size=shape) for shape in ((n, 3, 3), (n, 3, 3), (n, 3)))
        return [
            Mesh(x @ (np.eye(3) + 0.15 * A) + 0.1 * np.sin(2 * x @ B + p), sphere.faces)
            for A, B, p in zip(linear, waves, phases, strict=True)
        ]

    return make


@pytest.fixture(scope="session")
def meshes(deformed_spheres):
    """Six deformed spheres of 162 vertices."""
    return deformed_spheres(6, 2)


@pytest.fixture
def spheres(meshes):
    """A function (kind, key) → the six as a collection of two groups."""

    def make(kind=ShapeList, key="spheres"):
        shapes = kind(meshes)
        shapes.key, shapes.groups = key, {"half": np.array(list("aaabbb")), "parity": np.array([0, 1, 0, 1, 0, 1])}
        return shapes

    return make


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache of its own, whatever the environment says."""
    monkeypatch.delenv("LSSD_CACHE", raising=False)
    return Cache(tmp_path / "cache")


@pytest.fixture
def small_mesh_folder(deformed_spheres, tmp_path):
    """Five deformed spheres of 162 vertices as PLY files."""
    folder = tmp_path / "shapes"
    folder.mkdir()
    for i, mesh in enumerate(deformed_spheres(5, 2)):
        save(mesh, folder / f"shape_{i}.ply")
    return folder


@pytest.fixture(scope="session")
def pieces_of():
    """A function (out, overrides) → the pieces of a run in that folder; `choices` are those a task speaks of.

    In one process, if nothing else is said: two of loky's take ten seconds to import what they need.
    """

    def make(out, *overrides, **choices):
        overrides = ["parallel.workers=1", *map(str, overrides)]
        with initialize_config_dir(str(conf()), version_base="1.3"):
            config = OmegaConf.to_container(compose("config", overrides=overrides), resolve=True)
        choices = dict.fromkeys(("collection", "network", "net"), "") | choices
        out.mkdir(exist_ok=True)
        return Pieces.from_config(config, choices, instantiate, out, "python train.py again")

    return make


@pytest.fixture
def runs_of(pieces_of, tmp_path, monkeypatch):
    """A function (overrides) → a function (more of them) → metrics of a run in `tmp_path`, on a cache of its own."""
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))

    def make(*fixed, **choices):
        def run(*overrides, out=tmp_path):
            pieces = pieces_of(tmp_path, *fixed, *overrides, **choices)
            return pieces.task(pieces, out)

        return run

    return make


@pytest.fixture
def leave_run(tmp_path):
    """A function that leaves what a run leaves: its overrides, and metrics or an error line."""

    def make(name, overrides, metrics, error=None):
        folder = tmp_path / name
        (folder / ".hydra").mkdir(parents=True)
        (folder / ".hydra" / "overrides.yaml").write_text("\n".join(f"- {line}" for line in overrides) + "\n")
        if metrics is not None:
            (folder / "metrics.json").write_text(json.dumps(metrics))
        if error is not None:
            (folder / "error.txt").write_text(error)
        return folder

    return make
