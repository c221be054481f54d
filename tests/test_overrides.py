"""The border of the command line: a mistake is one line that names what there is."""

from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from lssd_learn.app import conf
from lssd_learn.errors import InputError
from lssd_learn.overrides import check

GROUPS = sorted(folder for folder in conf().iterdir() if folder.is_dir() and folder.name != "hydra")
CHOICES = [(folder.name, file.stem) for folder in GROUPS for file in sorted(folder.glob("*.yaml"))]


def composed(*overrides):
    with initialize_config_dir(str(conf()), version_base="1.3"):
        return compose("config", overrides=list(overrides))


@pytest.mark.parametrize(("group", "choice"), CHOICES)
def test_every_yaml_composes_and_passes_the_border(group, choice):
    check([f"{group}={choice}"], conf())
    assert group in composed(f"{group}={choice}") or group == "experiment"


@pytest.mark.parametrize(("group", "choice"), [c for c in CHOICES if c[0] in ("collection", "network", "net", "task")])
def test_every_choice_with_a_target_is_made(group, choice, tmp_path):
    (tmp_path / "a.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n0 0 1\n")
    extra = {"folder": [f"collection.path={tmp_path}"], "edges": ["network.edges=[[0,1]]"]}.get(choice, [])
    node = composed(f"{group}={choice}", *extra)[group]
    assert callable(instantiate(node)) or len(instantiate(node))


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("latent.kep=3", r"no latent.kep; latent has size, keep, operators$"),
        ("+latent.kep=3", r"no latent.kep; latent has size, keep, operators$"),
        ("++latent.kep=3", r"no latent.kep; latent has size"),
        ("+latent.keep=3", r"is there already; leave the \+ away"),
        ("+nonsense=1", r"no nonsense; the configuration has collection, basis"),
        ("nonsense.deeper=1", r"no nonsense; there are collection"),
        ("latent.keep.deeper=1", r"no latent.keep"),
        ("net=cn", r"^net=cn: expected one of cnn, mlp, pointnet$"),
        ("net=cnn,pointnet,mpl", r"^net=mpl: expected one of"),
        ("latent.keep=ten", r"^latent.keep=ten: expected a whole number, as in latent.keep=40$"),
        ("latent.keep=20,2.5", r"^latent.keep=2.5: expected a whole number"),
        ("net.learning_rate=fast", r"expected a number"),
        ("net.final_relu=1", r"expected true or false"),
        ("latent.operators=area", r"expected a list, as in latent.operators=\[area\]"),
        ("collection.topology=[1]", r"expected a word"),
        ("seed=null", r"seed=None: expected a whole number"),
        ("latent=3", r"latent=3: expected one of default"),
        ("data.split=2", r"expected one of its keys, as in data.split.train"),
        ("~data", r"cannot be taken away"),
        ("network.neighbours=5", r"no network.neighbours"),
    ],
)
def test_a_wrong_argument_is_refused_with_the_right_ones(argument, message):
    with pytest.raises(InputError, match=message) as caught:
        check([argument], conf())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "arguments",
    [
        ["seed=0"],
        ["latent.keep=5,10,20"],
        ["network=nearest", "network.neighbours=5"],
        ["collection=folder", "collection.path=anywhere", "collection.groups=[age]"],
        ["net.learning_rate=1"],
        ["ckpt_path=last"],
        ["-m", "seed=range(0,5)", "hydra.sweep.dir=x"],
        ["basis.k=${latent.size}"],
    ],
)
def test_a_right_argument_passes(arguments):
    check(arguments, conf())


def test_the_configuration_is_found_in_a_checkout():
    assert (Path(conf()) / "config.yaml").is_file()
