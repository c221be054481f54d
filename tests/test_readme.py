"""What the README and docs/ show is what there is."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.command.overrides import check
from lssd_learn.command.sizes import bring_down
from lssd_learn.command.typed import as_typed
from lssd_learn.errors import InputError
from lssd_learn.models import Trained
from lssd_learn.pieces import Pieces

ROOT = Path(__file__).parents[1]
PROGRAM = re.compile(r"^ *(python train\.py|lssd)(?= |$)")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(language, pages=PAGES):
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    return re.findall(rf"```{language}\n(.*?)```", text.replace("\\\n", " "), re.S)


def test_the_notebook_snippet_runs(common_cache, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(common_cache))
    snippet, from_a_checkpoint = blocks("python", [ROOT / "README.md"])
    names = {}
    exec(snippet, names)
    area, conformal = names["area"], names["conformal"]
    assert area.shape == conformal.shape == (40, 20, 20)
    np.testing.assert_allclose(area.mean(0), np.eye(20), atol=1e-10)
    assert names["bend"].shape == (615,)
    assert names["pushed"].area.shape == (20, 20)
    assert names["features"].shape == (1, 420)
    own = names["reader"].matrices([names["new"]])[0]
    np.testing.assert_allclose(own, np.stack([names["pushed"].area, names["pushed"].conformal]), atol=1e-6)
    assert all(callable(getattr(Trained, name)) for name in re.findall(r"model\.(\w+)\(", from_a_checkpoint))


def test_the_snippet_on_formats_runs(tmp_path):
    (tmp_path / "landmarks.tps").write_text("LM3=1\n1 2 3\nID=a\nLM3=1\n4 5 6\nID=b\n")
    exec(blocks("python", [ROOT / "docs" / "formats.md"])[0], {"folder": tmp_path})
    assert {file.name for file in tmp_path.glob("*.mrk.json")} == {"a.mrk.json", "b.mrk.json"}


def test_the_snippets_on_landmarks_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names, (make, compare) = {}, blocks("python", [ROOT / "docs" / "landmarks.md"])
    exec(make.replace("identities=6", "identities=1").replace("sets[:7]", "sets[:1]"), names)
    assert sorted(file.name for file in Path("heads").glob("*.json")) == ["face_00_happy.mrk.json"]
    Path("carried/markups").mkdir(parents=True)
    shutil.copy("known.tps", "carried/markups/landmarks.tps")
    exec(compare.replace("[7:]", "[1:]"), names)
    assert capsys.readouterr().out == "face_00_sad 0.0\n"


def test_the_snippet_on_gradients_runs():
    names = {}
    exec(
        next(block for block in blocks("python", [ROOT / "docs" / "operators.md"]) if "differentiable" in block), names
    )
    assert names["D"].shape == (3, 20, 20)
    assert names["moves"].shape == (615, 3)
    assert 0 < float(names["moves"].norm()) < float("inf")


@pytest.fixture
def workplace(small_mesh_folder, tmp_path, monkeypatch):
    """A folder in which the folders and checkpoints that the commands name are there."""
    monkeypatch.chdir(tmp_path)
    text = "".join(blocks("bash"))
    for name in sorted(set(re.findall(r"collection\.path=(\w+)", text)) | {"my_shapes"}):
        shutil.copytree(small_mesh_folder, name)
    for name in set(re.findall(r"ckpt_path=([\w/]+\.ckpt)", text)):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).touch()


def jobs(arguments):
    """The first and the last job of a command, as overrides; those of an experiment's own sweep are left out."""
    overrides = OverridesParser.create().parse_overrides([a for a in arguments if "=" in a])
    (batch,) = BasicSweeper.split_arguments(overrides, None)
    return {tuple(batch[0]), tuple(batch[-1])}


def test_every_command_is_right_as_far_as_shows_before_the_work(workplace):
    """Choices, keys, types, and all that the pieces of a run check of each other when they are made."""
    lines = [line.split("#")[0] for block in blocks("bash") for line in block.splitlines()]
    commands = [PROGRAM.sub("", part) for line in lines for part in line.split("&&") if PROGRAM.match(part)]
    assert len(commands) >= 70
    for command in commands:
        arguments = as_typed(shlex.split(command), conf())
        if {"--help", "--version"} & set(arguments) or arguments[:1] == ["measure"]:
            continue
        if extra := re.search(r"\bparallel=((?:joblib|ray|submitit)\w*)", command):  # a plugin's, not installed here
            assert (conf() / "parallel" / f"{extra[1]}.yaml").is_file()
            continue
        check(arguments, conf())
        # Launchers are extras of the installation: tests/test_app.py has those that are there.
        arguments = [
            a
            for a in arguments
            if not a.startswith(
                ("parallel=joblib", "parallel=submitit", "parallel=dask", "parallel=ray", "hydra.launcher.")
            )
        ]
        for job in jobs(arguments):
            with initialize_config_dir(str(conf()), version_base="1.3"):
                cfg = compose("config", overrides=list(job), return_hydra_config=True)
            choices = dict(cfg.hydra.runtime.choices)
            config = OmegaConf.to_container(OmegaConf.masked_copy(cfg, [k for k in cfg if k != "hydra"]), resolve=True)
            bring_down(config, job)
            Pieces.from_config(config, choices, instantiate, Path(), "")


def test_a_command_whose_numbers_do_not_fit_would_be_seen(workplace):
    with initialize_config_dir(str(conf()), version_base="1.3"):
        cfg = compose("config", overrides=["basis.k=50"], return_hydra_config=True)
    config = OmegaConf.to_container(OmegaConf.masked_copy(cfg, [k for k in cfg if k != "hydra"]), resolve=True)
    with pytest.raises(InputError, match=r"latent.size=64: expected 1 to k=50"):
        Pieces.from_config(config, dict(cfg.hydra.runtime.choices), instantiate, Path(), "")


def test_the_files_they_name_are_there():
    for page in PAGES:
        text = page.read_text()
        for name in re.findall(r"\]\(((?!http)[^)]+)\)", text):
            assert (page.parent / name).exists(), name
        for table in re.findall(r"`((?:docs/)?results/\w+\.csv)`", text):
            assert (page.parent / table).exists(), table


def test_every_picture_is_shown_somewhere():
    shown = {
        (page.parent / name).resolve()
        for page in PAGES
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text())
    }
    pictures = {file.resolve() for kind in ("png", "jpg", "gif", "svg") for file in (ROOT / "docs").rglob(f"*.{kind}")}
    assert pictures == {file for file in shown if file.is_relative_to(ROOT / "docs")}


def test_every_table_of_results_has_its_command():
    rows = re.findall(r"^\| `(\w+\.csv)` \| (.*) \|$", (ROOT / "docs/results/README.md").read_text(), re.M)
    assert sorted(name for name, _ in rows) == sorted(file.name for file in (ROOT / "docs/results").glob("*.csv"))
    for name, how in rows:
        commands = re.findall(r"`(python train\.py [^`]+)`", how)
        assert commands, name
        for command in commands:
            check([part for part in shlex.split(command)[2:] if "…" not in part], conf())
