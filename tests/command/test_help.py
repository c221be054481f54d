"""`--help`: everything it tells stands in the yamls, and nothing that a run needs is imported for it."""

import os
import re
import shlex
import subprocess
import sys
from importlib.metadata import version

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from lssd_learn.command.help import ROOMS, tell
from lssd_learn.command.overrides import check
from lssd_learn.command.typed import as_typed
from lssd_learn.command.yamls import conf, groups, told
from lssd_learn.errors import InputError

FOLDERS = [conf()]
GROUPS = groups(FOLDERS)
CHOICES = [(group, choice) for group, choices in GROUPS.items() for choice in choices]


def leaves(content, prefix=""):
    """The keys of nested dicts, those of empty ones too, by dots."""
    for name, value in content.items():
        if isinstance(value, dict) and value:
            yield from leaves(value, f"{prefix}{name}.")
        elif name not in ("_target_", "_partial_"):
            yield f"{prefix}{name}"


def composed(arguments):
    with initialize_config_dir(str(conf()), version_base="1.3"):
        return compose("config", overrides=arguments)


@pytest.mark.parametrize(("group", "choice"), [pair for pair in CHOICES if pair[0] not in ("experiment", "parallel")])
def test_the_keys_told_are_those_there_are_and_each_means_something(group, choice):
    one = told(FOLDERS, group, choice)
    cfg = OmegaConf.to_container(composed([f"{group}={choice}"]))
    if one.package == "_global_":
        assert all(
            OmegaConf.select(OmegaConf.create(cfg), key.name) is not None or key.value == "null" for key in one.keys
        )
        return
    assert set(leaves(cfg[group])) == {key.name for key in one.keys if key.value}
    assert all(key.meaning for key in one.keys if "." not in key.name)


@pytest.mark.parametrize(("group", "choice"), CHOICES)
def test_every_choice_says_what_it_is(group, choice):
    one = told(FOLDERS, group, choice)
    assert len(one.what) > 5
    assert one.what in re.sub(r"\s+", " ", tell([f"{group}={choice}", "--help"]))


@pytest.mark.parametrize("task", GROUPS["task"])
def test_every_task_has_an_example_that_is_right_as_far_as_it_shows(task):
    examples = told(FOLDERS, "task", task).examples
    assert examples
    for example in examples:
        program, *arguments = shlex.split(example)
        assert program == "lssd"
        assert f"task={task}" in arguments
        arguments = as_typed(arguments, conf())
        check(arguments, conf())
        OmegaConf.to_container(composed(arguments), resolve=True, throw_on_missing=True)


def test_the_overview_tells_every_task_under_its_room_and_every_other_choice(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = tell(["--help"])
    parts = re.split("|".join(f"{title}, as task=…" for title in ROOMS.values()), text)[1:]
    for room, part in zip(ROOMS, parts, strict=True):
        names = set(re.findall(r"^  (\w+)", part.partition("\nOther choices")[0], re.M))
        assert names == {n for n in GROUPS["task"] if told(FOLDERS, "task", n).target.startswith(f"lssd_learn.{room}.")}
    for group, choice in CHOICES:
        assert group == "task" or choice in text
    assert max(map(len, f"{text}\n{tell(['--hydra-help'])}".splitlines())) <= 80


def test_it_answers_without_what_a_run_imports():
    code = (
        "import sys; from lssd_learn.__main__ import main; sys.argv[1:] = {}; main();"
        "sys.exit(bool(sys.modules.keys() & {{'torch', 'hydra', 'numpy', 'scipy'}}))"
    )
    for arguments, expected in ((["--help"], "compare "), (["task=compare", "-h"], "task.blocks=null"),
                                (["--hydra-help"], "--config-dir"),
                                (["--version"], f"lssd_learn {version('lssd_learn')}\n")):  # fmt: skip
        done = subprocess.run(
            [sys.executable, "-c", code.format(arguments)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert expected in done.stdout


@pytest.mark.parametrize(
    "argument", ["collection.m=3", "collection=bodie", "seed=two", "seed=1,2", "[", "collection.n="]
)
def test_what_is_wrong_is_refused_without_what_a_run_imports(argument):
    code = (
        "import atexit, os, sys; from lssd_learn.__main__ import main; sys.argv[1:] = [sys.argv[1]];"
        "atexit.register(lambda: os._exit(2) if sys.modules.keys() & {'torch', 'numpy'} else None); main()"
    )
    done = subprocess.run([sys.executable, "-c", code, argument], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("error: ")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["task=compar"], "^task=compar: expected one of agreement, align, .*compare.*, surface_benchmark$"),
        (["compare"], "^compare: expected group=choice or one of the groups basis, collection, .*trainer$"),
        (["--config-dir=nowhere"], "nowhere: expected a folder of the configuration, and there is none$"),
    ],
)
def test_what_is_not_there_is_told_in_a_line(arguments, message):
    with pytest.raises(InputError, match=message):
        tell([*arguments, "--help"])


def test_a_folder_of_ones_own_is_told_too(tmp_path):
    (tmp_path / "task").mkdir()
    (tmp_path / "task" / "mine.yaml").write_text("# What is mine.\n_target_: mine.run\nn: 3 # how often\n")
    where = f"--config-dir={tmp_path}"
    assert re.search("Of plug-ins, as task=…\n  mine  +What is mine\n", tell([where, "--help"]))
    assert tell(["task=mine", where, "--help"]) == "task=mine: What is mine.\n\n  task.n=3  how often"


@pytest.mark.parametrize("option", ["--help", "--cfg job"])
def test_a_reader_who_has_enough_sees_no_traceback(option):
    line = f"{sys.executable} -m lssd_learn {option} | head -n 1"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
    assert (done.stderr, done.stdout.count("\n")) == ("", 1)


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("task=co", {"task=compare"}),
        ("task=compare task.me", {"task.mean=", "task.method="}),
        ("latent.ke", {"latent.keep="}),
    ],
)
def test_the_shell_completes_without_what_a_run_imports(typed, expected):
    line = f"lssd {typed}"
    code = (
        "import sys; sys.argv = ['lssd', '-sc', 'query=bash']; from lssd_learn.__main__ import main; main();"
        "sys.exit('torch' in sys.modules)"
    )
    env = os.environ | {"COMP_LINE": line, "COMP_POINT": str(len(line))}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=env)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == expected
