import pytest
import torch
from torch.nn import functional as F

from lssd_learn.errors import InputError
from lssd_learn.nets import DGCNN, reads
from lssd_learn.nets.dgcnn import SLOPE

SMALL = {"neighbours": 5, "widths": (6, 7), "embedding": 16, "decoder": (8,)}


def edge_conv_plain(convolution, features, k, graph_of):
    """One cloud, edge by edge: the linear layer on (x_i, x_j − x_i), then the maximum over j."""
    neighbours = torch.cdist(graph_of, graph_of).argsort(-1)[:, :k]
    own = features.unsqueeze(1).expand(-1, k, -1)
    edges = torch.cat([own, features[neighbours] - own], dim=-1)
    return F.leaky_relu(convolution.norm(convolution.linear(edges)), SLOPE).amax(1)


def dgcnn_plain(net, clouds):
    results = []
    for cloud in clouds:
        features = [cloud]
        for convolution in net.convolutions:
            graph_of = features[-1].detach() if net.dynamic else cloud
            features.append(edge_conv_plain(convolution, features[-1], net.neighbours, graph_of))
        results.append(F.leaky_relu(net.embed(torch.cat(features[1:], -1)), SLOPE).amax(0))
    return net.decoder(torch.stack(results))


def make(**options):
    torch.manual_seed(0)
    return DGCNN(3, 64, 12, **{**SMALL, **options}).double()


@pytest.fixture
def clouds():
    return torch.randn(4, 64, 3, generator=torch.Generator().manual_seed(1), dtype=torch.float64)


@pytest.mark.parametrize("dynamic", [True, False])
def test_results_and_gradients_are_those_of_the_plain_way(clouds, dynamic):
    net = make(dynamic=dynamic, norm="none")  # with a norm the maximum comes first, which is another function
    results = []
    for forward in (net, lambda x: dgcnn_plain(net, x)):
        x = clouds.clone().requires_grad_()
        loss = forward(x).square().sum()
        results.append([loss, *torch.autograd.grad(loss, [x, *net.parameters()])])
    for fast, plain in zip(*results, strict=True):
        torch.testing.assert_close(fast, plain, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("norm", ["none", "layer", "batch"])
def test_gradients_are_differences(norm):
    torch.manual_seed(0)
    net = DGCNN(3, 12, 2, neighbours=3, widths=(4, 4), embedding=5, decoder=(4,), norm=norm).double()
    x = torch.randn(3, 12, 3, generator=torch.Generator().manual_seed(2), dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(net, (x,))


@pytest.mark.parametrize("norm", ["none", "layer", "batch"])
def test_the_order_of_the_points_does_not_matter(clouds, norm):
    net = make(norm=norm)
    torch.testing.assert_close(net(clouds[:, torch.randperm(64)]), net(clouds))


def test_where_a_cloud_lies_does_not_matter_to_its_edges(clouds):
    net = make()
    shift = torch.tensor([1.0, -2.0, 3.0], dtype=torch.float64)
    with torch.no_grad():
        net.convolutions[0].linear.weight[:, :3] = 0  # the part that sees the point itself
    torch.testing.assert_close(net(clouds + shift), net(clouds))


@pytest.mark.parametrize("norm", ["none", "layer", "batch"])
def test_a_cloud_does_not_see_the_others_once_trained(clouds, norm):
    net = make(norm=norm).eval()
    torch.testing.assert_close(net(clouds[2:3]), net(clouds)[2:3])


def test_options():
    net = DGCNN(3, 1024, 12)
    assert sum(p.numel() for p in net.parameters()) == 56_972
    static = DGCNN(3, 64, 12, dynamic=False, **SMALL)
    assert static(torch.randn(2, 64, 3)).shape == (2, 12)
    assert make().eval()(torch.zeros(0, 64, 3, dtype=torch.float64)).shape == (0, 12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"neighbours": 65}, "net.neighbours=65: expected a whole number, 1 to 64"),
        ({"neighbours": 0}, "net.neighbours=0: expected a whole number, 1 to 64"),
        ({"widths": (4, 0)}, "net.widths=0: expected a whole number, 1 or more"),
        ({"widths": ()}, "net.widths=: expected the width of one edge convolution at least"),
        ({"embedding": 0}, "net.embedding=0: expected a whole number, 1 or more"),
        ({"norm": "instance"}, "net.norm=instance: expected one of none, layer, batch"),
    ],
)
def test_errors(options, message):
    with pytest.raises(InputError, match=message):
        make(**options)


def test_reads():
    assert reads(DGCNN) == "clouds"
