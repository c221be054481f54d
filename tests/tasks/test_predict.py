"""`task=predict`: a net reads new shapes in the language it has learnt."""

import csv

import numpy as np
import pytest
import torch
import trimesh

from lssd_learn.collections import Bodies, Remeshed
from lssd_learn.errors import InputError
from lssd_learn.models.trained import read_trained
from lssd_learn.shapes import Mesh, PointCloud, save

BODIES = ("collection=bodies_small", "collection.n=40")
SMALL = (*BODIES, "basis.k=40", "latent.size=24", "latent.keep=20", "latent.operators=[area,conformal]")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("predict")


@pytest.fixture(scope="module")
def trained(home, program):
    """A checkpoint of a CNN with layers of its own, trained on the operators of 40 bodies."""
    program(home / "trained", *SMALL, "task.epochs=60", "net.layers=[[10,3,2]]")
    return home / "trained" / "best.ckpt"


DOUBTS = ["size", "unlike", "trusted"]  # the last columns


def table(path):
    """The header, the names and the numbers, those that say how far to trust them left out."""
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    assert header[-3:] == DOUBTS
    return header[:-3], [row[0] for row in rows], np.array([row[1:-3] for row in rows], dtype=float)


def write_folder(folder, bodies, labels=None):
    folder.mkdir()
    for name, body in zip(bodies.names, bodies, strict=True):
        save(body, folder / f"{name}.ply")
    if labels:
        columns = [bodies.parameter_names.index(name) for name in labels]
        rows = [[name, *row] for name, row in zip(bodies.names, bodies.parameters[:, columns], strict=True)]
        (folder / "labels.csv").write_text("\n".join(",".join(map(str, row)) for row in [["name", *labels], *rows]))
    return folder


@pytest.fixture
def new_bodies():
    return Bodies(n=4, seed=1, topology="notoes_collapse5pc")


def test_bodies_of_another_seed_are_predicted_about_as_well_as_the_test_split(program, trained, tmp_path):
    """By a net in the checkpoint and none of the configuration, whose k, size and operators play no part."""
    metrics = program(tmp_path, "task=predict", f"ckpt_path={trained}", *BODIES, "collection.seed=1", "net=mlp")
    assert metrics["shapes"] == 40
    header, names, values = table(tmp_path / "predictions.csv")
    bodies = Bodies(n=40, seed=1)
    assert header == ["name", *bodies.parameter_names]
    assert names == bodies.names
    assert np.mean((values - bodies.parameters) ** 2) == pytest.approx(metrics["test/mse"], rel=1e-4)
    mean = np.mean((bodies.parameters - Bodies(n=40).parameters.mean(0)) ** 2)
    assert metrics["test/mse"] < 0.9 * mean
    assert np.abs(values - bodies.parameters).mean() == pytest.approx(metrics["test/l1"], rel=1e-4)


def test_a_training_shape_is_predicted_as_from_its_own_operator(program, trained, home, tmp_path):
    program(tmp_path, "task=predict", f"ckpt_path={trained}", *BODIES)
    model = read_trained(trained, None)
    operators = torch.stack(model.latent.differences(symmetric=True), dim=1)
    assert model.operators == ["area", "conformal"]
    np.testing.assert_allclose(table(tmp_path / "predictions.csv")[2], model.outputs(operators), atol=0.05)


def test_a_folder_gets_the_same_and_is_scored_where_it_has_the_parameters(
    program, trained, new_bodies, tmp_path, caplog
):
    folder = write_folder(tmp_path / "new", new_bodies)
    arguments = ("task=predict", f"ckpt_path={trained}", "collection=folder", f"collection.path={folder}")
    assert program(tmp_path / "a", *arguments) == {"shapes": 4, "trusted": 4}
    reordered = list(reversed(new_bodies.parameter_names))
    labelled = write_folder(tmp_path / "labelled", new_bodies, reordered)
    metrics = program(tmp_path / "b", *arguments[:-1], f"collection.path={labelled}")
    direct = program(
        tmp_path / "c", "task=predict", f"ckpt_path={trained}", *BODIES[:1], "collection.n=4", "collection.seed=1"
    )
    assert metrics["test/mse"] == pytest.approx(direct["test/mse"], rel=1e-3)
    assert table(tmp_path / "a/predictions.csv")[0][1:] == new_bodies.parameter_names
    values = [table(tmp_path / f"{run}/predictions.csv")[2] for run in "abc"]
    np.testing.assert_array_equal(values[0], values[1])
    np.testing.assert_allclose(values[0], values[2], atol=1e-3)  # a PLY has float32
    some = write_folder(tmp_path / "some", new_bodies, ["height"])
    with caplog.at_level("INFO"):
        assert program(tmp_path / "d", *arguments[:-1], f"collection.path={some}") == {"shapes": 4, "trusted": 4}
    assert "does not say what muscle, weight" in caplog.text


def test_a_classifier_tells_the_group_and_how_sure_it_is(program, home, tmp_path, new_bodies):
    program(home / "poses", *SMALL, "task=classification", "net=kernel")
    arguments = ("task=predict", f"ckpt_path={home / 'poses' / 'best.ckpt'}")
    metrics = program(tmp_path, *arguments, *BODIES, "collection.seed=1")
    with (tmp_path / "predictions.csv").open(newline="") as stream:
        header, *rows = csv.reader(stream)
    bodies = Bodies(n=40, seed=1)
    labels = sorted(set(bodies.groups["pose"]))
    assert header == ["name", "pose", *(f"pose={label}" for label in labels), *DOUBTS]
    truth = bodies.groups["pose"]
    assert metrics["test/accuracy"] == np.mean([row[1] == pose for row, pose in zip(rows, truth, strict=True)])
    assert metrics["test/accuracy"] > 0.8
    chances = np.array([row[2:-3] for row in rows], dtype=float)
    np.testing.assert_allclose(chances.sum(1), 1, atol=1e-4)
    assert [labels[i] for i in chances.argmax(1)] == [row[1] for row in rows]
    folder = write_folder(tmp_path / "folder", new_bodies)
    assert program(tmp_path, *arguments, "collection=folder", f"collection.path={folder}") == {
        "shapes": 4,
        "trusted": 4,
    }


@pytest.mark.parametrize(
    ("left", "message"),
    [
        ({"latent"}, "holds no latent space"),
        ({"parameters"}, "does not name its parameters or classes"),
        ({"net"}, "does not name its net"),
    ],
)
def test_a_checkpoint_of_something_else_is_refused(program, trained, tmp_path, left, message):
    checkpoint = torch.load(trained, weights_only=True)
    torch.save({name: value for name, value in checkpoint.items() if name not in left}, tmp_path / "other.ckpt")
    wanted = "expected the best.ckpt of task=regression or task=classification"
    with pytest.raises(InputError, match=rf"other.ckpt: {wanted}, but it {message}"):
        program(tmp_path, "task=predict", f"ckpt_path={tmp_path / 'other.ckpt'}", *BODIES)
    with pytest.raises(InputError, match="last.ckpt: expected the best.ckpt"):
        program(tmp_path, "task=predict", f"ckpt_path={trained.with_name('last.ckpt')}", *BODIES)
    assert not (tmp_path / "predictions.csv").exists()


def test_a_net_of_somebody_else_is_not_looked_up(program, trained, tmp_path):
    checkpoint = torch.load(trained, weights_only=True)
    options = {"layers": [[10, 3, 2]], "final_relu": False, "permute": None}
    assert checkpoint["net"] == ["lssd_learn.nets.cnn.CNN", options]
    torch.save(checkpoint | {"net": ["somewhere.Else", {}]}, tmp_path / "other.ckpt")
    arguments = ("task=predict", f"ckpt_path={tmp_path / 'other.ckpt'}", "collection=bodies_small", "collection.n=2")
    with pytest.raises(InputError, match="its net is somewhere.Else, but somewhere is no plug-in of lssd_learn"):
        program(tmp_path, *arguments, "net.layers=[[10,3,2]]")


def test_no_checkpoint_other_faces_and_clouds_are_told_before_any_work(program, trained, tmp_path):
    with pytest.raises(InputError, match="task=predict: expected ckpt_path=…"):
        program(tmp_path, "task=predict", *BODIES)
    arguments = ("task=predict", f"ckpt_path={trained}", "maps=correspondence")
    with pytest.raises(InputError, match=r"body_0000: expected a mesh in vertex correspondence .*615 vertices"):
        program(tmp_path, *arguments, "collection.n=2", "collection.topology=notoes_collapse3pc")
    (tmp_path / "in").mkdir()
    save(PointCloud(np.random.default_rng(0).normal(size=(99, 3))), tmp_path / "in" / "scan.xyz")
    with pytest.raises(InputError, match="scan: expected a mesh .* got 99 points and no faces"):
        program(tmp_path, *arguments, "collection=folder", f"collection.path={tmp_path / 'in'}")


def test_one_stranger_among_the_shapes_is_named(program, trained, new_bodies, tmp_path):
    folder = write_folder(tmp_path / "new", new_bodies)
    mesh = new_bodies[0]
    save(Mesh(mesh.vertices, mesh.faces[::-1]), folder / "stranger.ply")
    how = ("task=predict", f"ckpt_path={trained}", "maps=correspondence", "collection=folder")
    with pytest.raises(InputError, match=r"^stranger: expected a mesh in vertex correspondence"):
        program(tmp_path, *how, f"collection.path={folder}")


def test_what_comes_through_bad_maps_is_told(program, trained, tmp_path, caplog):
    """Two bodies with meshes of their own, turned, and a ball; by two maps each."""
    bodies = Remeshed(Bodies(n=2, seed=1, topology="notoes_collapse5pc"), vertices=(550, 600), turned="any")
    folder = write_folder(tmp_path / "new", bodies)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    save(Mesh(ball.vertices * (1 + 0.3 * np.sin(6 * ball.vertices[:, :1])), ball.faces), folder / "ball.ply")
    how = ("task=predict", f"ckpt_path={trained}", "collection=folder", f"collection.path={folder}")
    found = program(tmp_path, *how, "maps=auto", "task.mapped=2", "task.candidates=2")
    with (tmp_path / "predictions.csv").open(newline="") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    assert list(rows["ball"])[-5:] == ["size", "unlike", "map_quality", "trusted_maps", "trusted"]
    assert (rows["ball"]["trusted_maps"], rows["ball"]["trusted"]) == ("0", "0")
    assert float(rows["ball"]["map_quality"]) < 0.5
    for name in bodies.names:
        assert (float(rows[name]["map_quality"]) >= 0.5) == (int(rows[name]["trusted_maps"]) > 0)
    assert found["trusted"] == sum(row["trusted"] == "1" for row in rows.values())
    (line,) = (line for line in caplog.messages if "predictions are not to be trusted" in line)
    assert "ball" in line


def test_missing_eigenbases_name_the_command_that_makes_them_again(program, trained, tmp_path):
    with pytest.raises(InputError, match="is missing; make it again with: python train.py again"):
        program(
            tmp_path, "task=predict", f"ckpt_path={trained}", "maps=correspondence", *BODIES, cache=tmp_path / "empty"
        )


@pytest.mark.parametrize(
    ("net", "factor", "unit"),
    [
        ("trained", 1000, "in mm, those in m"),
        ("trained", 39.37, "in inches, those in m"),
        ("points", 1000, "in mm, those in m"),
    ],
)
def test_shapes_in_another_unit_do_not_go_unnoticed(
    program, trained, home, new_bodies, tmp_path, caplog, net, factor, unit
):
    if net == "points":
        program(home / "points", *SMALL, "net=pointnet", "net.variant=A", "data.points=64", "task.epochs=1")
    folder = tmp_path / "new"
    folder.mkdir()
    for name, body in zip(new_bodies.names, new_bodies, strict=True):
        save(Mesh(factor * body.vertices, body.faces), folder / f"{name}.ply")
    caplog.clear()
    arguments = ("task=predict", f"ckpt_path={home / net / 'best.ckpt'}", "collection=folder")
    program(tmp_path, *arguments, f"collection.path={folder}")
    (line,) = (line for line in caplog.messages if "the model was trained on" in line)
    assert line.startswith("4 of 4 shapes (body_0000, …)")
    assert unit in line
    assert "4 of 4 predictions are not to be trusted: body_0000, body_0001, body_0002, body_0003" in caplog.messages
    with (tmp_path / "predictions.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["trusted"] for row in rows} == {"0"}
    np.testing.assert_allclose([float(row["size"]) for row in rows], factor, rtol=0.4)  # people differ, and so do poses


@pytest.mark.slow
@pytest.mark.parametrize(
    ("net", "factor", "unit"),
    [
        ("kernel", 1000, "in mm, those in m"),
        ("kernel", 100, "in cm, those in m"),
        ("kernel", 39.37, "in inches, those in m"),
        ("trained", 100, "in cm, those in m"),
    ],
)
def test_no_shape_in_another_unit_gets_a_number_without_a_warning(
    program, trained, home, tmp_path, caplog, net, factor, unit
):
    """Eight of another seed, all named or counted; and forty of them in metres raise no alarm."""
    if net == "kernel" and not (home / "kernel").exists():
        program(home / "kernel", *SMALL, "net=kernel")
    bodies = Bodies(n=8, seed=1, topology="notoes_collapse5pc")
    folder = tmp_path / "new"
    folder.mkdir()
    for name, body in zip(bodies.names, bodies, strict=True):
        save(Mesh(factor * body.vertices, body.faces), folder / f"{name}.ply")
    arguments = ("task=predict", f"ckpt_path={home / net / 'best.ckpt'}")
    caplog.clear()
    program(tmp_path / "out", *arguments, "collection=folder", f"collection.path={folder}")
    (line,) = (line for line in caplog.messages if "the model was trained on" in line)
    assert line.startswith("8 of 8 shapes (body_0000, …)")
    assert unit in line
    caplog.clear()
    program(tmp_path / "metres", *arguments, *BODIES, "collection.seed=1")
    assert not [record for record in caplog.records if record.levelname == "WARNING"]


def test_bodies_of_another_seed_raise_no_alarm(program, trained, tmp_path, caplog):
    program(tmp_path, "task=predict", f"ckpt_path={trained}", *BODIES, "collection.seed=1")
    assert not [record for record in caplog.records if record.levelname == "WARNING"]
    with (tmp_path / "predictions.csv").open(newline="") as stream:
        rows = [(float(row["size"]), float(row["unlike"])) for row in csv.DictReader(stream)]
    sizes, shares = np.array(rows).T
    assert 0.6 < sizes.min() < sizes.max() < 1.5
    assert 0.25 < shares.mean() < 0.9
