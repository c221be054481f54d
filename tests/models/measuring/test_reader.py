import json
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from PIL import Image

from lssd_learn.collections import AtHand, Bodies, People
from lssd_learn.command import measure
from lssd_learn.errors import InputError
from lssd_learn.models.measuring import BodyReader, train_reader
from lssd_learn.models.measuring.table import as_rows, read_all
from lssd_learn.shapes import Mesh, PointCloud, save
from lssd_learn.tasks import measure as task

SMALL = "notoes_collapse5pc"


@pytest.fixture(scope="module")
def people():
    return People(n=40, topology=SMALL)


@pytest.fixture(scope="module")
def others():
    return People(n=20, seed=1, topology=SMALL)


@pytest.fixture(scope="module")
def made(people, others):
    return train_reader(people, others, others, references=6, taught=10)


@pytest.fixture(scope="module")
def strangers():
    return People(n=6, seed=2, topology=SMALL)


def test_it_reads_people_in_correspondence_far_better_than_the_mean(made, strangers):
    truth = strangers.parameters
    read = np.array([made.reader.read(shape).values for shape in strangers])
    away = np.abs(truth - np.exp(made.reader.mean)).mean(0)
    assert np.mean(np.abs(read - truth).mean(0) / away) < 0.25
    assert np.abs(read - truth)[:, 0].mean() < 15
    assert made.read.shape == (10, truth.shape[1])


def test_no_motion_and_no_unit_changes_what_is_read(made, strangers):
    turn = trimesh.transformations.random_rotation_matrix(np.random.default_rng(0).random(3))[:3, :3]
    body = strangers[0]
    scan = Mesh(1000 * (body.vertices @ turn.T + 3), body.faces)
    reading = made.reader.read(scan)
    assert reading.unit == "mm"
    np.testing.assert_allclose(reading.values, made.reader.read(body).values, rtol=1e-6)
    assert (reading.low < reading.values).all()
    np.testing.assert_allclose(reading.values**2, reading.low * reading.high)


def test_the_file_is_the_reader_and_the_same_bytes_each_time(made, people, others, strangers, tmp_path):
    path = made.reader.save(tmp_path / "reader.npz")
    again = train_reader(people, others, others, references=6, taught=10).reader.save(tmp_path / "again.npz")
    assert path.read_bytes() == again.read_bytes()
    read = BodyReader.load(path)
    assert read.names == made.reader.names
    np.testing.assert_allclose(read.read(strangers[1]).values, made.reader.read(strangers[1]).values, rtol=1e-4)


def test_what_is_no_person_is_refused_in_one_line(made, strangers, caplog):
    ball = trimesh.creation.icosphere(2, radius=0.4)
    body = strangers[0]
    giant, cloud = Mesh(9 * body.vertices, body.faces), PointCloud(body.vertices)
    shapes = AtHand([Mesh(ball.vertices, ball.faces), giant, body, cloud])
    with caplog.at_level("WARNING"):
        found, refused = read_all(made.reader, shapes)
    assert list(found) == ["2"]
    assert not caplog.records
    assert len(refused) == 3
    assert refused[2] == "3: expected a mesh, got a cloud of 615 points: reconstruct its surface"
    assert refused[0].startswith("0: expected a whole body of a grown-up")
    assert refused[1].startswith("1: expected a body in m, cm or mm")


def test_the_command_prints_a_table_and_ends_with_status_one_where_a_scan_is_refused(
    made, strangers, tmp_path, capsys, monkeypatch
):
    reader, table = made.reader.save(tmp_path / "reader.npz"), tmp_path / "out.json"
    for i in range(2):
        save(strangers[i], tmp_path / f"scan_{i}.ply")
    (tmp_path / "empty.ply").write_text("")
    scans = [str(tmp_path / f"{name}.ply") for name in ("scan_0", "scan_1")]
    assert measure.main([*scans, "--reader", str(reader), "--json", str(table)]) == 0
    out = capsys.readouterr().out
    assert "scan_1 (in m; 90 % intervals)" in out
    assert "chest girth" in out
    rows = json.loads(table.read_text())["scans"]
    assert rows[0]["height_mm_low"] < rows[0]["height_mm"] < rows[0]["height_mm_high"]
    assert set(as_rows(made.reader, {"x": made.reader.read(strangers[0])})[0]) == set(rows[0])
    monkeypatch.setenv("LSSD_READER", str(reader))
    assert measure.main([scans[0], str(tmp_path / "empty.ply")]) == 1
    told = capsys.readouterr()
    assert "scan_0" in told.out
    assert len(told.err.splitlines()) == 1
    assert "empty.ply" in told.err


def test_the_reader_of_the_package_reads_people_that_it_has_not_seen(strangers, tmp_path, capsys, monkeypatch):
    monkeypatch.delenv("LSSD_READER", raising=False)
    save(strangers[3], tmp_path / "scan.ply")
    shown = ["--csv", str(tmp_path / "out.csv"), "--pictures", str(tmp_path / "drawn")]
    assert measure.main([str(tmp_path / "scan.ply"), *shown]) == 0
    with Image.open(tmp_path / "drawn" / "scan.png") as picture:
        assert (np.asarray(picture.convert("RGB"))[..., 0] > 150).any()
    assert "scan (in m; 90 % intervals)" in capsys.readouterr().out
    read = np.array([BodyReader.load().read(shape).values for shape in strangers])
    off = np.abs(read / strangers.parameters - 1).mean(0)
    assert off[0] < 0.01
    assert off.max() < 0.08


def test_the_tapes_of_the_package_lie_on_a_scan_where_its_girths_are(strangers):
    reader, body = BodyReader.load(), strangers[3]
    reading = reader.read(Mesh(1000 * body.vertices, body.faces))
    assert len(reader.loops) == 8
    for name, loop in reader.loops.items():
        corners = loop.on(reading.points)
        around = np.linalg.norm(np.roll(corners, 1, axis=0) - corners, axis=1).sum()
        assert around == pytest.approx(reading.values[list(reader.names).index(name)], rel=0.25), name


def test_files_that_hold_no_reader_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file; expected a reader"):
        BodyReader.load(tmp_path / "none.npz")
    (tmp_path / "other.npz").write_text("else")
    with pytest.raises(InputError, match="expected a reader of body measures"):
        BodyReader.load(tmp_path / "other.npz")


def test_the_task_writes_tables_of_a_folder_and_names_what_it_refuses(made, strangers, tmp_path, caplog):
    reader = made.reader.save(tmp_path / "reader.npz")
    body, giant = strangers[0], Mesh(9 * strangers[0].vertices, strangers[0].faces)
    pieces = SimpleNamespace(pipeline=SimpleNamespace(collection=AtHand([body, giant])))
    assert task.run(pieces, tmp_path, str(reader)) == {"shapes": 1, "refused": 1}
    assert "1: expected a body in m, cm or mm" in caplog.text
    header, row = (tmp_path / "measures.csv").read_text().splitlines()
    assert header.startswith("name,unit,height_mm,height_mm_low,height_mm_high")
    assert row.startswith("0,m,")
    pieces.pipeline.collection = AtHand([giant])
    with pytest.raises(InputError, match="none of 1 scans can be read; the first: 0: expected a body in m"):
        task.run(pieces, tmp_path, str(reader))


def test_the_task_scores_itself_where_measures_are_known(made, strangers, tmp_path):
    reader = made.reader.save(tmp_path / "reader.npz")
    pieces = SimpleNamespace(pipeline=SimpleNamespace(collection=strangers))
    metrics = task.run(pieces, tmp_path, str(reader))
    read = np.array([made.reader.read(shape).values for shape in strangers])
    assert metrics["l1/height_mm"] == pytest.approx(np.abs(read - strangers.parameters)[:, 0].mean(), rel=1e-3)
    assert metrics["l1/waist_girth_mm"] < metrics["mean/waist_girth_mm"]
    assert 0.5 < metrics["held"] <= 1


def test_chords_of_a_map_that_slides_are_no_body_at_last(made, strangers):
    points = strangers[0].points
    slid = points + np.random.default_rng(0).normal(scale=0.1, size=points.shape)
    features = made.reader.chords(np.stack([points, slid]))
    near, far = made.reader.unlike(features)
    assert near < made.reader.farthest < far


def test_what_a_reader_cannot_be_made_of_is_refused(people, others):
    with pytest.raises(InputError, match=r"task.taught=20: expected a whole number, 4 to 19"):
        train_reader(people, others, others, references=6, taught=20)
    with pytest.raises(InputError, match=r"task.scans: expected the parameters of the collection"):
        train_reader(people, Bodies(n=20, topology=SMALL), others, references=6, taught=10)


@pytest.mark.slow
def test_scans_that_correspond_to_nothing_are_read_better_than_by_the_mean(pieces_of, tmp_path, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
    small = ["collection.n=60", "task.references=20", f"collection.topology={SMALL}"]
    scans = ["task.scans=30", "task.taught=18", "task.vertices=[1200,1500]"]
    pieces = pieces_of(tmp_path, "experiment=measures", *small, *scans)
    metrics = pieces.task(pieces, tmp_path)
    assert metrics["trusted"] > 0.8
    assert metrics["l1/height_mm"] < 40
    assert (tmp_path / "reader.npz").stat().st_size < 10e6
