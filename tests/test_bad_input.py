"""Bad input, from the command line on: one line that names place and fault, exit status 1, nothing half-written."""

import errno
import logging
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from lssd_learn import app
from lssd_learn.shapes import Mesh, PointCloud, load, save

SMALL = ("task=operators", "collection=folder", "collection.path=in", "basis.k=12", "latent.size=8", "latent.keep=6")
TETRAHEDRON = Mesh(np.eye(4)[:, :3], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


@pytest.fixture
def folder(small_mesh_folder, tmp_path, monkeypatch):
    """Three shapes in `in/` of an empty working directory."""
    for i in (3, 4):
        (small_mesh_folder / f"shape_{i}.ply").unlink()
    monkeypatch.chdir(tmp_path)
    return small_mesh_folder.rename(tmp_path / "in")


@pytest.fixture
def program(folder, tmp_path, monkeypatch, capsys):
    """A function that runs the program in this process, and gives its exit status and what it said."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level

    def run(*arguments):
        monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr(sys, "argv", ["train.py", *map(str, arguments)])
        for of_this_process in ("_begun", "_failures", "_sweeps", "_places"):
            monkeypatch.setattr(app, of_this_process, [])
        try:
            app.main()
            status = 0
        except SystemExit as end:
            status = end.code
        finally:
            for handler in root.handlers:
                handler.close()
            root.handlers[:] = handlers
            root.setLevel(level)
        return status, capsys.readouterr().err.splitlines()

    return run


def refused(program, *arguments):
    """The one line of an error."""
    status, lines = program(*arguments)
    assert status == 1
    errors = [line for line in lines if line.startswith("error: ")]
    assert len(errors) == 1
    assert lines[-1] == errors[0]  # nothing after it, no traceback
    assert not list(Path().rglob("*.npz")) + list(Path().rglob("metrics.json")) + list(Path().rglob("*.draft"))
    return errors[0].removeprefix("error: ")


def write(name, content):
    def make(folder):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())

    return make


def without_shapes(folder):
    for file in folder.iterdir():
        file.unlink()


def cut_off(folder):
    write("shape_1.ply", (folder / "shape_1.ply").read_bytes()[:1500])(folder)


def with_a_crumb(folder):
    """Shape 1 with a piece of four vertices, 0 to 3, and a landmark on it."""
    crumb, whole = TETRAHEDRON, (folder / "shape_1.ply")

    mesh = load(whole)
    save(Mesh(np.vstack([0.01 * crumb.vertices, mesh.vertices]), np.vstack([crumb.faces, mesh.faces + 4])), whole)
    write("landmarks.csv", "name,landmark,vertex\nshape_1,nose,2\n")(folder)


UNLIKE = ["collection.correspondence=none", "maps=correspondence"]
LABELS = "name,sex,side\nshape_0,m,left\nshape_1,f,left\nshape_2,f,left\n"
OFF = "OFF\n3 1 0\n0 0 0\n1 {} 0\n0 1 0\n3 0 1 {}\n"


@pytest.mark.parametrize(
    ("spoil", "arguments", "message"),
    [
        (None, ["latent.kep=3"], "latent.kep=3: there is no latent.kep; latent has size, keep, operators, fitted"),
        (None, ["+latent.kep=3"], "+latent.kep=3: there is no latent.kep; latent has size, keep, operators, fitted"),
        (None, ["latent.keep=many"], "latent.keep=many: expected a whole number, as in latent.keep=40"),
        (None, ["latent.keep=100"], "latent.keep=100: expected 1 to size=8"),
        (None, ["latent.size=90"], "latent.size=90: expected 1 to k=12"),
        (None, ["net=cn"], "net=cn: expected one of"),
        (None, ["data.protocol=none"], "data.protocol=none: "),
        (None, ["collection.path=???"], "collection.path: expected a value"),
        (None, ["net.learning_rate=nan"], "net.learning_rate=nan: expected a number above 0"),
        (None, ["collection.path=nowhere"], "nowhere: expected a folder of shapes, it is not there"),
        (None, ["collection.path=in ü"], "\"collection.path='in ü'\""),
        (None, ["ckpt_path=nowhere"], "ckpt_path=nowhere: expected a checkpoint, but there is no file 'nowhere'"),
        (without_shapes, [], "in: expected shapes (.off .obj .ply .stl .glb .vtk .vtp .xyz), found none"),
        (cut_off, [], "in/shape_1.ply: expected PLY, it is damaged, cut off or something else"),
        (write("shape_1.ply", ""), [], "in/shape_1.ply: expected a shape, the file is empty"),
        (write("shape_1.ply", bytes(range(256))), [], "in/shape_1.ply: expected PLY, it is damaged"),
        (write("x.off", OFF.format("nan", 2)), [], "in/x.off: vertices: expected finite coordinates, 1 of 3 are not"),
        (write("x.off", OFF.format(0, 7)), [], "in/x.off: expected OFF"),
        (lambda folder: save(TETRAHEDRON, folder / "x.off"), ["maps=registration"], "x: k: expected 1 to 3, fewer"),
        (with_a_crumb, [], "landmark 'nose' is at vertex 2 of another piece, which is dropped"),
        (write("labels.csv", "name,age\nshape_0,1\n"), [], "in/labels.csv: expected a row for every shape, got none"),
        (write("labels.csv", "name\nshape_0\nshape_0\n"), [], "line 3: expected one row a shape, got a second one"),
        (write("labels.csv", "name,größe\n".encode("latin-1")), [], "in/labels.csv: expected comma-separated text"),
        (write("maps/shape_0__shape_1.txt", "1\n2\n"), [], "maps/shape_0__shape_1.txt: expected a vertex of shape_0"),
        (None, ["network=edges", "network.edges=[[0,1]]"], "edges: expected a connected network, got 2 components"),
        (None, ["network=edges", "network.edges=[[0,9]]"], "edges: expected shape numbers 0 to 2, got 0 to 9"),
        (None, UNLIKE, "shape_0 and shape_1 are not in vertex correspondence"),
        (None, ["task=regression"], "task=regression: expected shapes with parameters; this collection has none"),
        (None, ["task=classification"], "task.group: expected shapes with groups; this collection has none"),
        (write("labels.csv", LABELS), ["task=classification"], "task.group: expected one of sex, side"),
        (write("labels.csv", LABELS), ["task=classification", "task.group=eye"], "task.group=eye: expected one of sex"),
        (write("labels.csv", LABELS), ["task=classification", "task.group=side"], "every shape is 'left'"),
        (None, ["task=predict"], "task=predict: expected ckpt_path=…, the best.ckpt of a task=regression"),
        (write("../x.ckpt", "?"), ["task=predict", "ckpt_path=x.ckpt"], "x.ckpt: expected a checkpoint, but it cannot"),
        (write("../file", "in the way"), ["hydra.run.dir=file"], "file: the folder of the run cannot be written"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(program, folder, spoil, arguments, message):
    if spoil:
        spoil(folder)
    assert message in refused(program, *SMALL, *arguments)


def test_a_damaged_cache_entry_is_made_again_and_said_once(program, tmp_path):
    assert program(*SMALL)[0] == 0
    (file,) = (tmp_path / "cache" / "latent").glob("*/*.arrays")
    sound = file.read_bytes()
    file.write_bytes(bytes([sound[0] ^ 1]) + sound[1:])
    status, lines = program(*SMALL, "hydra.run.dir=again")
    assert status == 0
    assert sum("is damaged (Y has a wrong checksum) and is made again" in line for line in lines) == 1
    assert file.read_bytes() == sound


def test_a_checkpoint_of_another_latent_space_is_refused(program, folder, deformed_spheres):
    for i, mesh in enumerate(deformed_spheres(10, 1)):
        save(mesh, folder / f"shape_{i}.ply")
    write("labels.csv", "name,age\n" + "".join(f"shape_{i},{i}\n" for i in range(10)))(folder)
    training = (*SMALL[1:], "task.epochs=1")
    assert program(*training, "hydra.run.dir=first")[0] == 0
    Path("first/metrics.json").unlink()
    for other, message in (
        ("network=star", "first/last.ckpt: expected what it was made with, but network was clique, now star"),
        ("latent.keep=5", "latent.keep was 6, now 5"),
        ("net=mlp", "net was cnn, now mlp"),
    ):
        assert message in refused(program, *training, other, "ckpt_path=first/last.ckpt")


def test_two_shapes_are_a_collection_and_clouds_are_told_what_they_lack(program, folder):
    (folder / "shape_2.ply").unlink()
    assert program(*SMALL, "hydra.run.dir=two")[0] == 0
    shutil.rmtree("two")
    for i in range(2):
        save(PointCloud(np.random.default_rng(i).normal(size=(99, 3))), folder / f"shape_{i}.ply")
    assert "shape_0 and shape_1 are not in vertex correspondence" in refused(program, *SMALL, "maps=correspondence")


@pytest.mark.filterwarnings("ignore")
def test_a_full_disk_is_said(program, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(app, "run", full)
    told = refused(program, *SMALL, "hydra.run.dir=out")
    assert told.endswith("out: the folder of the run cannot be written: No space left on device")
    assert Path("out/error.txt").read_text().strip() == told


def test_an_interrupt_is_said_and_ends_with_130(program, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(app, "run", interrupted)
    status, lines = program(*SMALL)
    assert status == 130
    assert lines[-1].startswith("error: interrupted; to go on (what was computed is in the cache): python train.py")


def test_an_interrupted_sweep_says_how_it_goes_on_and_keeps_what_is_done(program, monkeypatch):
    run, done = app.run, []

    def second_interrupted(cfg):
        done.append(cfg)
        if len(done) == 2:
            raise KeyboardInterrupt
        return run(cfg)

    monkeypatch.setattr(app, "run", second_interrupted)
    sweep = ("-m", *SMALL, "latent.keep=4,5")
    status, lines = program(*sweep, "hydra.sweep.dir=sweep")
    assert status == 130
    assert lines[-1].startswith("error: interrupted; to go on (jobs that are done are kept): python train.py -m ")
    *_, where = lines[-1].split()
    assert where == "hydra.sweep.dir=sweep"
    assert len(Path("sweep/summary.csv").read_text().splitlines()) > 1
    kept = Path("sweep/0/metrics.json").stat().st_mtime_ns
    assert program(*sweep, where)[0] == 0
    assert len(done) == 2 + 1  # the first job is not run again
    assert Path("sweep/0/metrics.json").stat().st_mtime_ns == kept
    assert Path("sweep/1/metrics.json").exists()


def test_options_may_stand_anywhere(program):
    status, lines = program(*SMALL, "-m", "latent.keep=4,99", "hydra.sweep.dir=sweep")
    assert status == 1
    assert any(line.startswith("error: latent.keep=99: expected 1 to size=8") for line in lines)
    assert [Path(f"sweep/{job}/metrics.json").exists() for job in (0, 1)] == [True, False]
