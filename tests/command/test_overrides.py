"""The border of the command line: a mistake is one line that names what there is."""

import importlib.metadata
import re
from pathlib import Path

import pytest
from hydra.errors import HydraException
from hydra.utils import instantiate

from lssd_learn.app import conf
from lssd_learn.command.composed import composed
from lssd_learn.command.overrides import check, explain
from lssd_learn.errors import InputError

GROUPS = sorted(folder for folder in conf().iterdir() if folder.is_dir() and folder.name != "hydra")
CHOICES = [(folder.name, file.stem) for folder in GROUPS for file in sorted(folder.glob("*.yaml"))]
# The choices that come with an extra of the package.
PLUGINS = {
    "joblib": "hydra_joblib_launcher",
    "submitit_local": "hydra_submitit_launcher",
    "submitit_slurm": "hydra_submitit_launcher",
    "ray": "hydra_ray_launcher",
    "optuna": "hydra_optuna_sweeper",
}


def is_installed(plugin):
    try:
        return bool(importlib.metadata.version(plugin))
    except importlib.metadata.PackageNotFoundError:
        return False


@pytest.mark.parametrize(("group", "choice"), CHOICES)
def test_every_yaml_composes_and_passes_the_border(group, choice):
    plugin = PLUGINS.get(choice)
    if plugin is not None and not is_installed(plugin):
        with pytest.raises(HydraException) as caught:
            check([f"{group}={choice}"], conf())
        assert re.search(rf"not installed: pip install 'lssd_learn\[{plugin.split('_')[1]}\]'$", explain(caught.value))
        return
    check([f"{group}={choice}"], conf())
    assert group in composed(conf(), [f"{group}={choice}"]) or group == "experiment"


@pytest.mark.parametrize(("group", "choice"), [c for c in CHOICES if c[0] in ("collection", "network", "net", "task")])
def test_every_choice_with_a_target_is_made(group, choice, tmp_path):
    (tmp_path / "a.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
    (tmp_path / "a.vts").write_text("1\n2\n3\n4\n")
    path = [f"collection.path={tmp_path}"]
    extra = {"collection/folder": path, "collection/benchmark": path, "network/edges": ["network.edges=[[0,1]]"]}
    node = composed(conf(), [f"{group}={choice}", *extra.get(f"{group}/{choice}", [])])[group]
    assert callable(instantiate(node)) or len(instantiate(node))


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("latent.kep=3", r"no latent.kep; latent has size, keep, operators, fitted, device; did you mean keep\?$"),
        ("+latent.kep=3", r"no latent.kep; latent has size, keep, operators, fitted, device; did you mean keep\?$"),
        ("++latent.kep=3", r"no latent.kep; latent has size"),
        ("+latent.keep=3", r"is there already; leave the \+ away"),
        ("+nonsense=1", r"no nonsense; the configuration has seed, ckpt_path, cache, collection, basis"),
        ("nonsense.deeper=1", r"no nonsense; there are seed, ckpt_path, cache, collection"),
        ("latent.keep.deeper=1", r"no latent.keep"),
        ("net=cn", r"^net=cn: expected one of autoencoder, cnn, dgcnn, kernel, mlp, "),
        ("net=cnn,pointnet,mpl", r"^net=mpl: expected one of.*; did you mean mlp\?$"),
        ("latent.keep=ten", r"^latent.keep=ten: expected a whole number, as in latent.keep=40$"),
        ("latent.keep=20,2.5", r"^latent.keep=2.5: expected a whole number"),
        ("net.learning_rate=fast", r"expected a number"),
        ("net.final_relu=1", r"expected true or false"),
        ("latent.operators=area", r"expected a list of words, as in latent.operators=\[area\]"),
        ("latent.operators=area,conformal", r"expected a list of words, as in latent.operators=\[area,conformal\]$"),
        ("collection.topology=[1]", r"expected a word"),
        ("seed=null", r"seed=null: expected a whole number"),
        ("task.epochs=null", r"task.epochs=null: expected a whole number"),
        ("latent=3", r"latent=3: expected one of both, default$"),
        ("data.split=2", r"expected one of its keys, as in data.split.train"),
        ("~data", r"cannot be taken away"),
        ("network.neighbours=5", r"no network.neighbours"),
        ("net._target_=os.system", r"there is no net._target_; net has learning_rate"),
        ("latent.operators=[[area]]", r"expected a list of words"),
        ("debug.epochs={a:1}", r"debug.epochs={a:1}: expected a value"),
        ("latent.operators=[area", r"^latent.operators=\[area: cannot be understood; a list is \[a,b\]"),
        ("regression", r"^'regression': expected key=value or group=choice"),
        ("=3", r"^'=3': expected key=value"),
        ("", r"^'': expected key=value"),
        ("seed=0,1", r"^seed=0,1: several values want -m; a list is seed=\[a,b\]"),
    ],
)
def test_a_wrong_argument_is_refused_with_the_right_ones(argument, message):
    with pytest.raises(InputError, match=message) as caught:
        check([argument], conf())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", ["jürgen/scans", "~/scans", "a=b"])
def test_a_path_that_wants_quotes_is_shown_with_them(value):
    with pytest.raises(InputError, match="cannot be understood") as caught:
        check(["collection=folder", f"collection.path={value}"], conf())
    assert str(caught.value).endswith(f"\"collection.path='{value}'\"")
    check(["collection=folder", f"collection.path='{value}'"], conf())


@pytest.mark.parametrize("value", ["null", ""])
def test_a_value_that_has_to_be_given_is_not_nothing(value):
    with pytest.raises(InputError, match=rf"^collection.path={value}: expected a value$"):
        check(["collection=folder", f"collection.path={value}"], conf())


@pytest.mark.parametrize(
    "arguments",
    [
        ["seed=0"],
        ["-m", "latent.keep=5,10,20"],
        ["network=nearest", "network.neighbours=5"],
        ["collection=folder", "collection.path=anywhere", "collection.groups=[age]"],
        ["net.learning_rate=1"],
        ["ckpt_path=last"],
        ["-m", "seed=range(0,5)", "hydra.sweep.dir=x"],
        ["basis.k=${latent.size}"],
        ["--cfg", "job"],
        ["hydra.mode=MULTIRUN", "seed=0,1"],
        ["latent.operators=[area,conformal]", "net.layers=[[10,3,2]]"],
        ["experiment=paper_pool", "net.variant=A,B"],
        ["experiment=paper_pool", "net=cnn", "net.layers=null"],
        ["maps=landmarks", "maps.refined=null"],
        ["task=compare", "task.few=null"],
    ],
)
def test_a_right_argument_passes(arguments):
    check(arguments, conf())


def test_the_configuration_is_found_in_a_checkout():
    assert (Path(conf()) / "config.yaml").is_file()
