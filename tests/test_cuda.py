"""The same results on a GPU as on a CPU. Skipped where there is none."""

import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent import network as network_module
from lssd_learn.learning import ShapeData, fit, split
from lssd_learn.nets import CNN
from lssd_learn.nets.chamfer import chamfer
from lssd_learn.pipeline import Pipeline

needs_gpu = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
DEVICES = ["cpu", pytest.param("cuda", marks=needs_gpu)]


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("kind", ["clique", "spanning_tree"])
def test_operators_have_the_same_eigenvalues(truncated, kind, device, monkeypatch):
    monkeypatch.setattr(network_module, "EXACT_PRODUCTS", 0)  # the way of large collections
    network = getattr(MapNetwork, kind)(truncated(40, 30))
    there = LatentSpace.fit(network, 24, 12, device=device)
    assert there.Y.device.type == device
    expected, got = (space.to("cpu").differences(symmetric=True) for space in (LatentSpace.fit(network, 24, 12), there))
    for a, b in zip(expected, got, strict=True):
        torch.testing.assert_close(torch.linalg.eigvalsh(b), torch.linalg.eigvalsh(a), rtol=0, atol=1e-5)


@pytest.mark.parametrize("device", DEVICES)
def test_the_chamfer_distance_and_its_gradient_are_the_same(device):
    generator = torch.Generator().manual_seed(0)
    a, b = (torch.rand(3, 200, 3, generator=generator) for _ in range(2))
    results = []
    for place in ("cpu", device):
        cloud = a.to(place).requires_grad_()
        value = chamfer(cloud, b.to(place))
        value.backward()
        results.append((value.detach().cpu(), cloud.grad.cpu()))
    torch.testing.assert_close(results[1], results[0], rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("device", DEVICES)
def test_training_ends_at_the_same_error(device, tmp_path):
    generator = torch.Generator().manual_seed(0)
    inputs = torch.randn(40, 1, 20, 20, generator=generator)
    data = {"inputs": inputs, "targets": inputs[:, 0, :2, :2].flatten(1), "split": split(40, 0), "seed": 0}
    scores = []
    for name in ("cpu", "gpu" if device == "cuda" else "cpu"):
        options = {"accelerator": name, "devices": 1}
        metrics = fit(
            CNN, ShapeData(**data), epochs=5, learning_rate=1e-3, seed=0, out=tmp_path / name, trainer_options=options
        )
        scores.append(metrics["test/mse"])
    assert scores[1] == pytest.approx(scores[0], rel=1e-3)


def test_a_device_that_is_not_there_is_refused(meshes):
    for device in ["nonsense"] + ["cuda"] * (not torch.cuda.is_available()):
        with pytest.raises(InputError, match=f"latent.device={device}: expected a device of this machine: cpu"):
            Pipeline(meshes, device=device)
