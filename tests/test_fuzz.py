"""Every reader, fed with thousands of spoilt files: each ends in what was asked for or in an error of our own.

Within a second and without much memory, whatever size a file claims to have. Many more than the suite tries, and what
the worst of them took: `pytest -n 0 -m slow tests/test_fuzz.py -s`.
"""

import time
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
import torch
import trimesh

from lssd_learn.collections.landmark_files.files import FORMATS as LANDMARK_FORMATS
from lssd_learn.collections.landmark_files.files import read_specimens, suffix_of, write_specimens
from lssd_learn.collections.landmark_files.specimen import Specimen
from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import read_landmarks
from lssd_learn.collections.reading.listing import read_indices
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.learning.checkpoint import read
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis, load, save

SECONDS, MEGABYTES = 1.0, 500
NAMES = ("a", "b", "c")
HOSTILE = (
    "nan", "inf", "-1", "1e400", "0", "4294967295", "99999999999", "9" * 400, "x", "", "ü", "\0", ",", "\n", "1e",
    "0x10", "--", "../../etc/passwd", "🦴",
)  # fmt: skip


def _sphere() -> Mesh:
    sphere = trimesh.creation.icosphere(subdivisions=1)
    return Mesh(np.array(sphere.vertices), np.array(sphere.faces))


def _ascii(mesh: Mesh, kind: str) -> bytes:
    exported = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    if kind == "ply":
        return exported.export(file_type="ply", encoding="ascii")
    return exported.export(file_type="stl_ascii").encode()


@pytest.fixture(scope="module")
def targets(tmp_path_factory) -> dict[str, tuple[str, bytes, Callable]]:
    """What is spoilt: name → suffix, sound bytes, reader."""
    folder, mesh = tmp_path_factory.mktemp("sound"), _sphere()
    found = {}
    for suffix in ("off", "obj", "ply", "stl", "glb", "vtk", "vtp", "xyz"):
        path = folder / f"sound.{suffix}"
        save(PointCloud(mesh.vertices) if suffix == "xyz" else mesh, path)
        found[suffix] = (suffix, path.read_bytes(), load)
    for suffix in ("ply", "stl"):
        found[f"{suffix}, text"] = (suffix, _ascii(mesh, suffix), load)
    labels = "name,age,sex\na,1.5,f\nb,2,m\nc,3,f\n"
    found["labels"] = ("csv", labels.encode(), lambda path: read_labels(path, NAMES))
    marks = "name,landmark,vertex,x,y,z\na,nose,1,,,\nb,nose,,0,1,2\nc,ear,3,0,0,1\n"
    found["landmarks"] = ("csv", marks.encode(), lambda path: read_landmarks(path, NAMES))
    specimens = [Specimen(name, ("nose", "ear"), mesh.vertices[[3, i]], "LPS") for i, name in enumerate(NAMES)]
    for form in LANDMARK_FORMATS:
        (file,) = write_specimens(specimens[:1] if form in ("mrk.json", "fcsv", "pts") else specimens, folder, form)
        found[f"landmarks, {form}"] = (suffix_of(file.name)[1:], file.read_bytes(), read_specimens)
    found["map"] = ("txt", "\n".join(map(str, range(42))).encode(), read_indices)
    bases = [eigenbasis(Mesh(mesh.vertices * (1, 1, scale), mesh.faces), 8) for scale in (1, 1.2, 1.5)]
    LatentSpace.fit(MapNetwork.clique(bases), 6, 4).save(folder / "space.npz")
    found["latent space"] = ("npz", (folder / "space.npz").read_bytes(), LatentSpace.load)
    torch.save({"state_dict": {"w": torch.ones(9)}, "hyper_parameters": {}, "epoch": 1}, folder / "x.ckpt")
    found["checkpoint"] = ("ckpt", (folder / "x.ckpt").read_bytes(), read)
    return found


def spoilt(data: bytes, rng: np.random.Generator) -> bytes:
    """The file as damage, a mistake or somebody hostile may have left it."""
    way, size = rng.integers(9), len(data)
    at = int(rng.integers(size))
    if way == 0:
        return data[:at]
    if way == 1:
        bits = np.frombuffer(data, np.uint8).copy()
        where = rng.integers(size, size=rng.integers(1, 20))
        bits[where] ^= np.uint8(1) << rng.integers(8, size=len(where)).astype(np.uint8)
        return bits.tobytes()
    if way == 2:  # another header
        return rng.bytes(int(rng.integers(1, 100))) + data[int(rng.integers(min(size, 100))) :]
    if way == 3:  # a count that is not there
        huge = int(rng.choice([2**31 - 1, 2**32 - 1, 2**30, 10**7])).to_bytes(4, "little")
        return data[:at] + huge + data[at + 4 :]
    if way == 4:  # one word for another
        words = data.split(b" ")
        words[int(rng.integers(len(words)))] = HOSTILE[rng.integers(len(HOSTILE))].encode()
        return b" ".join(words)
    if way == 5:
        lines = data.split(b"\n")
        i = int(rng.integers(min(len(lines), 12)))  # most of them in the header
        digits = [
            word if not word.isdigit() else HOSTILE[rng.integers(len(HOSTILE))].encode() for word in lines[i].split()
        ]
        lines[i] = b" ".join(digits)
        return b"\n".join(lines)
    if way == 6:
        return data[:at] + rng.bytes(int(rng.integers(1, 200))) + data[at:]
    if way == 7:
        lines = data.split(b"\n")
        rng.shuffle(lines)
        return b"\n".join(lines)
    return (b"", b"\n", b"\0" * 200, rng.bytes(300), data * 2)[rng.integers(5)]


@dataclass
class Tally:
    """What became of the inputs."""

    tried: int = 0
    read: int = 0
    seconds: float = 0.0
    megabytes: float = 0.0
    faults: list[str] = field(default_factory=list)


def feed(targets, each: int, folder, seed: int) -> Tally:
    """Spoil each of the targets so many times, and read it."""
    tally = Tally()
    tracemalloc.start()
    for t, (name, (suffix, data, reader)) in enumerate(targets.items()):
        for i in range(each):
            path = folder / f"x.{suffix}"
            path.write_bytes(spoilt(data, np.random.default_rng([seed, t, i])))
            tracemalloc.reset_peak()
            before, start = tracemalloc.get_traced_memory()[0], time.process_time()
            try:
                with warnings.catch_warnings(record=True) as said:
                    warnings.simplefilter("always")
                    reader(path)
                tally.read += 1
            except InputError as error:
                if "\n" in str(error):
                    tally.faults.append(f"{name} {i}: more than one line: {error}")
            except Exception as error:
                tally.faults.append(f"{name} {i}: {type(error).__name__}: {error}")
            if said:
                tally.faults.append(f"{name} {i}: warned: {said[0].message}")
            tally.tried += 1
            tally.seconds = max(tally.seconds, time.process_time() - start)
            tally.megabytes = max(tally.megabytes, (tracemalloc.get_traced_memory()[1] - before) / 1e6)
    tracemalloc.stop()
    return tally


def check(tally: Tally) -> None:
    assert not tally.faults, "\n".join([f"{len(tally.faults)} of {tally.tried}:", *tally.faults[:20]])
    assert 0 < tally.read < tally.tried  # some damage does no harm, most does
    assert tally.seconds < SECONDS
    assert tally.megabytes < MEGABYTES


def test_sound_files_are_read(targets, tmp_path):
    for name, (suffix, data, reader) in targets.items():
        (tmp_path / f"x.{suffix}").write_bytes(data)
        assert reader(tmp_path / f"x.{suffix}") is not None, name


def test_what_is_announced_and_not_there_is_not_allocated(tmp_path):
    announced = {"descr": "<f8", "fortran_order": False, "shape": (10**9,)}
    with zipfile.ZipFile(tmp_path / "x.npz", "w") as archive, archive.open("Y.npy", "w") as member:
        np.lib.format.write_array_header_1_0(member, announced)
        member.write(bytes(80))
    tracemalloc.start()
    with pytest.raises(InputError, match="x.npz: expected a saved latent space .* Y.npy announces 8,000,000,000 bytes"):
        LatentSpace.load(tmp_path / "x.npz")
    assert tracemalloc.get_traced_memory()[1] < 1e7
    tracemalloc.stop()


def test_spoilt_files(targets, tmp_path, caplog):
    check(feed(targets, 12, tmp_path, seed=0))
    assert {record.name for record in caplog.records} <= {"lssd_learn.shapes.files"}  # what was left out, and no more


@pytest.mark.slow
def test_thousands_of_spoilt_files(targets, tmp_path):
    tally = feed(targets, 300, tmp_path, seed=1)
    print(f"{tally.tried} inputs, {tally.read} read; at worst {tally.seconds:.2f} s and {tally.megabytes:.0f} MB")
    check(tally)
