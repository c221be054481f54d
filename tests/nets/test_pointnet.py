import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.nets import PointNet, reads
from lssd_learn.nets.pooling import pooled_features


def pooled_features_plain(layers, clouds):
    """All points through all layers, then the maximum."""
    values = clouds
    for layer in layers[:-1]:
        values = torch.relu(layer(values))
    return layers[-1](values).amax(1)


@pytest.fixture
def net():
    torch.manual_seed(0)
    return PointNet(3, 1024, 12).double()


@pytest.mark.parametrize(("variant", "parameters"), [("A", 11340), ("B", 34124), ("C", 43212)])
def test_number_of_parameters(variant, parameters):
    net = PointNet(3, 1024, 12, variant=variant)
    assert sum(p.numel() for p in net.parameters()) == parameters
    assert net(torch.randn(2, 30, 3)).shape == (2, 12)


@pytest.mark.parametrize(("n", "points"), [(5, 1024), (3, 700), (7, 300), (2, 3000), (4, 1)])
def test_gradients_are_those_of_the_plain_way(net, n, points):
    torch.manual_seed(1)
    clouds = torch.randn(n, points, 3, dtype=torch.float64)
    results = []
    for pool in (pooled_features, pooled_features_plain):
        x = clouds.clone().requires_grad_()
        features = torch.relu(pool(net.encoder, x))
        loss = (net.decoder(features) ** 2).sum()
        results.append([features, loss, *torch.autograd.grad(loss, [x, *net.parameters()])])
    for fast, plain in zip(*results, strict=True):
        torch.testing.assert_close(fast, plain, rtol=1e-8, atol=1e-8)


def test_the_order_of_the_points_does_not_matter(net):
    clouds = torch.randn(4, 200, 3, dtype=torch.float64)
    torch.testing.assert_close(net(clouds[:, torch.randperm(200)]), net(clouds))


def test_a_cloud_does_not_see_the_others(net):
    clouds = torch.randn(6, 300, 3, dtype=torch.float64)
    torch.testing.assert_close(net(clouds[2:3]), net(clouds)[2:3])


def test_no_clouds_give_no_predictions(net):
    assert net(torch.zeros(0, 10, 3, dtype=torch.float64)).shape == (0, 12)


def test_final_relu_is_an_option():
    torch.manual_seed(0)
    assert PointNet(3, 50, 12, final_relu=True)(torch.randn(9, 50, 3)).min() == 0


def test_unknown_variant():
    with pytest.raises(InputError, match="one of A, B, C, got 'D'"):
        PointNet(3, 1024, 12, variant="D")


def test_reads():
    assert reads(PointNet) == "clouds"
