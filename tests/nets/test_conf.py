"""Every yaml of the group makes a net once the shape of the input is known."""

from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.nets import is_solved, reads

CONF = Path(__file__).parents[2] / "conf" / "net"
INPUTS = {"operators": torch.zeros(2, 1, 40, 40), "clouds": torch.zeros(2, 1024, 3)}


@pytest.mark.parametrize(
    "name", ["autoencoder", "cnn", "dgcnn", "kernel", "mlp", "pointnet", "reconstructor", "vertices"]
)
def test_net_yaml(name):
    config = OmegaConf.load(CONF / f"{name}.yaml")
    learning_rate = config.pop("learning_rate")
    net = instantiate(config)
    assert learning_rate is None if is_solved(net) else learning_rate > 0
    channels, size = {"operators": (1, 40), "clouds": (3, 1024)}[reads(net)]
    assert net(channels=channels, size=size, outputs=12)(INPUTS[reads(net)]).flatten(1).shape == (2, 12)
