"""`task=model` and `task=null_benchmark` through the configuration, on spheres with and without a bump."""

import csv
import logging

import numpy as np
import pytest
import trimesh

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, save
from lssd_learn.view import highlights

SMALL = ("collection=folder", "basis.k=25", "latent.size=16", "latent.keep=12")


@pytest.fixture
def run(runs_of, deformed_spheres, tmp_path, monkeypatch):
    """A function (overrides) → metrics, of six deformed spheres, as they are and with a bump at the top."""
    monkeypatch.setattr(highlights, "LARGEST", 60)
    folder, lines = tmp_path / "spheres", ["name,person,state,age"]
    folder.mkdir()
    for person, mesh in enumerate(deformed_spheres(6, 2)):
        for state in ("after", "before"):
            top = np.exp(-np.square(trimesh.creation.icosphere(2).vertices - [0, 0, 1]).sum(1) / 0.3)[:, None]
            points = mesh.vertices * (1 + 0.1 * top * (state == "after"))
            save(Mesh(points, mesh.faces), folder / f"{state}_{person}.ply")
            lines.append(f"{state}_{person},p{person},{state},{20 + person**2}")
    (folder / "labels.csv").write_text("\n".join(lines) + "\n")
    return runs_of(*SMALL, f"collection.path={folder}")


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_formula_leaves_what_it_promises(run, tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        metrics = run("task=model", "task.formula='~ log(size) + state'", "task.permutations=99",
                      "latent.operators=[area,conformal]", "task.without='log(size)'")  # fmt: skip
    assert metrics["shapes"] == 12
    assert {name for name in metrics if name.endswith("/p")} == {
        f"{kind}/{term}/p" for kind in ("area", "conformal", "area+conformal") for term in ("log(size)", "state")
    }
    assert metrics["area/log(size)/p"] == 0.01
    rows = table(tmp_path / "model.csv")
    assert list(rows[0])[:9] == ["operator", "term", "df", "SS", "R2", "F", "Z", "p", "p smallest"]
    assert [row["term"] for row in rows[:4]] == ["log(size)", "state", "residuals", "total"]
    assert sum(float(row["R2"]) for row in rows[:3]) == pytest.approx(1, abs=1e-5)
    assert {row["pair"] for row in table(tmp_path / "pairwise.csv")} == {"1 sd of log(size)", "before - after"}
    scores = table(tmp_path / "scores.csv")
    assert len(scores) == 12
    assert {"name", "state", "log(size)", "area PC1", "area along log(size)"} <= set(scores[0])
    fields = table(tmp_path / "fields.csv")
    assert [(row["operator"], row["term"]) for row in fields] == [
        (kind, term) for kind in ("area", "conformal") for term in ("log(size)", "state")
    ]
    mesh = trimesh.load(tmp_path / "fields" / "field_area_state_before-after.ply", process=False)
    held = mesh.metadata["_ply_raw"]["vertex"]["data"]
    with np.load(tmp_path / "fields" / "field_area_state_before-after.npz") as arrays:
        np.testing.assert_allclose(held["effect"], arrays["effect"], rtol=1e-5)
        assert ((arrays["low"] < arrays["effect"]) & (arrays["effect"] < arrays["high"])).all()
        assert (np.abs(arrays["least"]) <= np.abs(arrays["effect"]) + 1e-9).all()
    with np.load(tmp_path / "corrected.npz") as arrays:
        assert arrays["area"].shape == (12, 12, 12)
    assert any("model.csv, pairwise.csv" in line for line in caplog.messages)
    made = {file.name for file in (tmp_path / "surfaces").iterdir()}
    titles = ("mean", "log_size_low", "log_size_high", "state_after-before_low", "state_after-before_high")
    assert made == {f"{name}{suffix}" for name in titles for suffix in (".ply", ".glb")}
    low, high = (trimesh.load(tmp_path / f"surfaces/state_after-before_{end}.ply", process=False)
                 for end in ("low", "high"))  # fmt: skip
    assert low.vertices[:, 2].max() > high.vertices[:, 2].max() + 0.03  # the bump
    assert np.abs(high.metadata["_ply_raw"]["vertex"]["data"]["moves"]).max() > 0.03
    text = (tmp_path / "report.html").read_text()
    assert len(text) < 15e6
    assert "12 shapes were compared by latent space shape differences" in text
    assert "“~ log(size) + state” with sums of squares of type I" in text
    assert "99 permutations" in text or "100 permutations" in text
    assert (tmp_path / "surfaces.png").stat().st_size > 5000


def test_the_same_people_twice(run, tmp_path):
    """People differ much more than the bump does, which is at the top and makes the area there larger."""
    metrics = run("task=model", "task.formula='~ state'", "task.blocks=person")
    assert metrics["area/state/p"] == metrics["area/state/anywhere"] == 2 / 2**6
    with np.load(tmp_path / "fields" / "field_area_state_before-after.npz") as arrays:
        mesh = trimesh.load(tmp_path / "fields" / "field_area_state_before-after.ply", process=False)
        z = mesh.vertices[:, 2]
        assert arrays["effect"][z > 0.8 * z.max()].max() < -3 < arrays["effect"][z < 0].min()
    assert run("task=model", "task.formula='~ state'")["area/state/p"] > 0.05


def test_shapes_of_which_something_is_unknown_are_left_out_by_name(run, tmp_path, caplog):
    file = tmp_path / "spheres" / "labels.csv"
    file.write_text(file.read_text().replace("before_2,p2,before", "before_2,p2,None"))
    assert run("task=model", "task.formula='~ state'", "task.permutations=9")["shapes"] == 11
    assert "1 of 12 shapes are left out, of which not all of state is known: before_2" in caplog.messages


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.formula='~ sex'"], "no column 'sex': expected some of person, state, age, area, size, volume"),
        (["task.formula='~ age'", "task.sums=IV"], "task.sums=IV: expected I, II or III"),
        (["task.formula='~ age'", "task.without=state"], "task.without=state: expected a number of the formula"),
        (["task.formula='~ state'", "task.blocks=state"], "blocks enough for residuals; state does not"),
        (["task.formula='~ age'", "task.permutations=0"], "task.permutations=0: expected a whole number"),
    ],
)
def test_mistakes_are_told_before_anything_is_computed(run, overrides, message, monkeypatch):
    monkeypatch.setattr("lssd_learn.pipeline.Pipeline.latent", property(lambda self: 1 / 0))
    with pytest.raises(InputError, match=message):
        run("task=model", *overrides)


def test_nothing_is_found_where_nothing_is(run, tmp_path):
    few = ("task=null_benchmark", "task.permutations=39", "task.points=30")
    rates = run(*few, "task.studies=10", "task.nuisance='log(size)'")
    places = ("table", "anywhere", "enhanced")
    assert set(rates) == {f"area/{what}/{where}" for what in ("groups", "numbers") for where in places}
    assert max(rates.values()) < 0.5
    assert len(table(tmp_path / "null.csv")) == 6
    within = run(*few, "task.studies=2", "task.blocks=person")
    assert {name.split("/")[1] for name in within} == {"groups within", "groups between", "numbers between"}


def test_a_term_that_others_say_too_has_no_field(run, tmp_path, caplog):
    file = tmp_path / "spheres" / "labels.csv"
    head, *lines = file.read_text().splitlines()
    again = [f"{line},{'x' if 'before' in line else 'y' if 'p1' in line else 'z'}" for line in lines]
    file.write_text("\n".join([f"{head},again", *again]) + "\n")
    found = run("task=model", "task.formula='~ state + again'", "task.permutations=9")
    assert {"area/state/p", "area/again/anywhere"} < set(found)
    assert "area/state/anywhere" not in found
    assert any(line.startswith("state says nothing that the other terms do not") for line in caplog.messages)
