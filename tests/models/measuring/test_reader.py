import json
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from PIL import Image

from lssd_learn.collections import AtHand, Bodies, Faulty, People
from lssd_learn.collections.generated.skinned import LOOSE, some_turns
from lssd_learn.command import measure
from lssd_learn.errors import InputError
from lssd_learn.models.measuring import BodyReader, laying, train_reader
from lssd_learn.models.measuring.reader import signs
from lssd_learn.models.measuring.report import write_report
from lssd_learn.models.measuring.table import as_rows, read_all, towards
from lssd_learn.shapes import Mesh, PointCloud, save
from lssd_learn.tasks import measure as task


@pytest.fixture(scope="module")
def reader():
    """That of the package."""
    return BodyReader.load()


@pytest.fixture(scope="module")
def strangers():
    return People(n=3, seed=905)


@pytest.fixture(scope="module")
def readings(reader, strangers):
    return [reader.read(shape) for shape in strangers]


@pytest.fixture(scope="module")
def made(known):
    clean, faulty = [People(n=3, seed=906)], [Faulty(People(n=5, seed=907))]
    with pytest.MonkeyPatch.context() as patch:  # a body of few people lies well on nobody: one try has to do
        patch.setattr(laying, "FOLLOWED", 1)
        patch.setattr(laying, "TRIED", 4)
        return train_reader(known, some_turns(12, 10, 0), LOOSE, clean, faulty, level=0.5, workers=1)


def test_people_that_it_has_not_seen_are_read_to_a_few_millimetres(readings, strangers):
    for reading, truth in zip(readings, strangers.parameters, strict=True):
        assert np.abs(reading.values - truth)[:13].max() < 15
        assert np.abs(reading.values - truth)[:13].mean() < 4
        assert (reading.low < reading.values).all()
        np.testing.assert_allclose(reading.values**2, reading.low * reading.high)
        assert not reading.signs


def test_no_motion_and_no_unit_changes_what_is_read_and_both_are_told(reader, strangers, readings):
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])[:3, :3]
    scan = Mesh(1000 * (strangers[0].vertices @ turn.T + 3), strangers[0].faces)
    reading = reader.read(scan)
    assert reading.unit == "mm"
    assert towards(readings[0]).startswith("+z")
    assert towards(reading).startswith("-y")
    np.testing.assert_allclose(reading.values, readings[0].values, rtol=0.01)
    assert np.abs(reading.points - scan.vertices).mean() < 20


def test_its_file_is_the_same_bytes_each_time_and_reads_the_same(made, strangers, tmp_path):
    path, again = (made.reader.save(tmp_path / name) for name in ("reader.npz", "again.npz"))
    assert path.read_bytes() == again.read_bytes()
    assert path.stat().st_size < 20e6
    read = BodyReader.load(path)
    assert read.names == made.reader.names
    np.testing.assert_array_equal(read.farthest, made.reader.farthest)
    assert read.save(again).read_bytes() == path.read_bytes()


def test_a_reader_that_learnt_from_few_reads_better_than_the_mean_and_its_intervals_hold_half(made):
    off, mean = np.abs(made.read - made.truth), np.abs(np.exp(made.reader.mean) - made.truth)
    assert (off.mean(0) < mean.mean(0)).mean() > 0.8
    assert made.kinds.tolist() == [0] * 3 + [1] * 5


def test_what_is_no_person_is_refused_in_one_line_and_a_fault_is_told(reader, strangers, caplog):
    body = strangers[0]
    giant, few = Mesh(9 * body.vertices, body.faces), PointCloud(body.vertices[::40])
    stays = body.vertices[:, 2] > np.median(body.vertices[:, 2])
    upper, index = np.unique(body.faces[stays[body.faces].all(1)], return_inverse=True)
    noise = np.random.default_rng(0).normal(scale=0.004, size=body.vertices.shape)
    rough = Mesh(body.vertices + noise, body.faces)
    half = Mesh(body.vertices[upper], index.reshape(-1, 3))
    shapes = AtHand([giant, few, half, rough])
    caplog.clear()
    found, refused = read_all(reader, shapes)
    assert list(found) == ["3"]
    assert found["3"].signs[0].startswith("rough or clothed: ")
    assert [line[:40] for line in refused] == [
        "0: expected a body in m, cm or mm, but i",
        "1: expected a scan of 1000 points or mor",
        "2: expected a whole body of a grown-up, ",
    ]
    assert not any("\n" in line for line in refused)


def test_signs_are_of_what_is_more_than_in_any_scan_without_faults():
    assert signs(np.array([0.1, 0.0, 0.0, 1.0]), np.array([0.5, 0.01, 0.01, 1.3])) == ()
    told = signs(np.array([3.0, 0.05, 0.0, 2.0]), np.array([0.5, 0.01, 0.01, 1.3]))
    assert told == (
        "rough or clothed: 3.0 mm off a body",
        "5 % of the body are missing",
        "unlike the people that the reader knows: 2.0 standard deviations from their mean",
    )


def test_the_command_prints_a_table_draws_and_ends_with_status_one_where_a_scan_is_refused(
    strangers, tmp_path, capsys, monkeypatch
):
    monkeypatch.delenv("LSSD_READER", raising=False)
    save(strangers[1], tmp_path / "scan.ply")
    (tmp_path / "empty.ply").write_text("")
    outs = {name: tmp_path / f"out.{name}" for name in ("json", "csv", "html")}
    shown = ["--json", str(outs["json"]), "--csv", str(outs["csv"]), "--report", str(outs["html"])]
    scans = [str(tmp_path / f"{name}.ply") for name in ("scan", "empty")]
    assert measure.main([*scans, *shown, "--pictures", str(tmp_path / "drawn")]) == 1
    told = capsys.readouterr()
    assert "scan (in m, up is +z; 90 % intervals)" in told.out
    assert "chest girth" in told.out
    assert len(told.err.splitlines()) == 1
    assert "empty.ply" in told.err
    row = json.loads(outs["json"].read_text())["scans"][0]
    assert row["height_mm_low"] < row["height_mm"] < row["height_mm_high"]
    assert outs["csv"].read_text().startswith("name,unit,up,height_mm,height_mm_low,height_mm_high")
    with Image.open(tmp_path / "drawn" / "scan.png") as picture:
        assert (np.asarray(picture.convert("RGB"))[..., 0] > 150).any()
    page = outs["html"].read_text()
    assert page.count("data:image/png;base64,") == 1
    assert "http" not in page.replace("http-equiv", "")
    assert "Not read" in page
    assert "in m; its hips stand up towards +z" in page


def test_names_on_the_page_are_shown_as_they_are(reader, strangers, readings, tmp_path):
    scans = AtHand([PointCloud(strangers[0].vertices)])
    scans.names = ["<b>&"]
    write_report(reader, scans, {"<b>&": readings[0]}, ["<i>: refused"], tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "<h2>&lt;b&gt;&amp;</h2>" in page
    assert "&lt;i&gt;: refused" in page
    with pytest.raises(InputError, match="cannot be written"):
        write_report(reader, scans, {}, [], tmp_path)


def test_tapes_lie_on_a_scan_where_its_girths_are(reader, readings):
    reading = readings[2]
    assert len(reading.tapes) == 8
    for name, tape in reading.tapes.items():
        around = 1000 * np.linalg.norm(np.roll(tape, 1, axis=0) - tape, axis=1).sum()
        assert around == pytest.approx(reading.values[list(reader.names).index(name)], rel=0.15), name


def test_files_that_hold_no_reader_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file; expected a reader"):
        BodyReader.load(tmp_path / "none.npz")
    (tmp_path / "other.npz").write_text("else")
    with pytest.raises(InputError, match="expected a reader of body measures"):
        BodyReader.load(tmp_path / "other.npz")
    np.savez(tmp_path / "old.npz", told=np.array([2.0, 0.9, 1.0]))
    with pytest.raises(InputError, match="expected a reader of format 3, got 2; make it again"):
        BodyReader.load(tmp_path / "old.npz")


def test_the_task_scores_itself_and_names_what_it_refuses(strangers, readings, tmp_path):
    person = People(n=1, seed=905)
    pieces = SimpleNamespace(pipeline=SimpleNamespace(collection=person))
    metrics = task.run(pieces, tmp_path, None, pictures=False)
    off = np.abs(readings[0].values - person.parameters[0])
    assert metrics["l1/height_mm"] == pytest.approx(off[0], rel=1e-3)
    assert metrics["l1/waist_girth_mm"] < metrics["mean/waist_girth_mm"]
    assert 0 <= metrics["held"] <= 1
    assert (metrics["shapes"], metrics["refused"], metrics["signs"]) == (1, 0, 0)
    assert not (tmp_path / "pictures").exists()
    giant = Mesh(9 * strangers[0].vertices, strangers[0].faces)
    pieces.pipeline.collection = AtHand([giant])
    with pytest.raises(InputError, match="none of 1 scans can be read; the first: 0: expected a body in m"):
        task.run(pieces, tmp_path, None)


def test_rows_name_all_that_is_known(reader, readings):
    row = as_rows(reader, {"x": readings[0]})[0]
    assert list(row)[:3] == ["name", "unit", "up"]
    assert list(row)[-5:] == ["off_mm", "missing", "extra", "unlike", "signs"]
    assert len(row) == 3 + 3 * 15 + 5


def test_what_a_reader_cannot_be_made_of_is_refused(known):
    turns = some_turns(4, 10, 0)
    with pytest.raises(InputError, match=r"task.scans=3: expected a whole number, 8 or more"):
        train_reader(known, turns, LOOSE, [People(n=2)], [People(n=1)], level=0.5)
    with pytest.raises(InputError, match=r"task.scans: expected scans whose parameters are the measures"):
        train_reader(known, turns, LOOSE, [Bodies(n=20)], [], level=0.5)


@pytest.mark.slow
def test_balls_and_the_like_are_refused(reader):
    ball = trimesh.creation.icosphere(4, radius=0.4)
    for stretched in ([1, 1, 1], [1, 1, 2], [1, 2, 3]):
        with pytest.raises(InputError, match="expected a whole body of a grown-up"):
            reader.read(Mesh(ball.vertices * stretched / np.sqrt(np.mean(np.square(stretched))), ball.faces))


@pytest.mark.slow
def test_the_reader_is_made_again_from_nothing_to_the_same_bytes(pieces_of, tmp_path, monkeypatch):
    small = ["collection.n=40", "task.poses=20", "task.scans=12", "task.vertices=[3000,4000]", "task.level=.5"]
    made = []
    for turn in "ab":
        monkeypatch.setenv("LSSD_CACHE", str(tmp_path / f"cache_{turn}"))
        (tmp_path / turn).mkdir()
        pieces = pieces_of(tmp_path / turn, "experiment=measures", *small)
        metrics = pieces.task(pieces, tmp_path / turn)
        made.append((tmp_path / turn / "reader.npz").read_bytes())
    assert made[0] == made[1]
    assert metrics["l1/height_mm"] < 30
