import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.nets import Reconstructor, chamfer, is_solved, reads
from lssd_learn.nets.cnn import SameConv


def test_it_is_the_papers():
    net = Reconstructor(1, 40, 3 * 4096)
    assert sum(p.numel() for p in net.parameters()) == 1_872_412
    convolutions = [m for m in net.modules() if isinstance(m, SameConv)]
    assert [(c.out_channels, c.kernel_size, c.stride) for c in convolutions] == [
        (20, (3, 3), (2, 2)),
        (20, (6, 6), (2, 2)),
    ]
    linear = [m.out_features for m in net.modules() if isinstance(m, torch.nn.Linear)]
    assert linear == [128, 128, 3 * 4096]


@pytest.mark.parametrize(("channels", "size", "points"), [(1, 40, 5), (2, 17, 1), (1, 1, 2)])
def test_any_size_and_two_channels(channels, size, points):
    net = Reconstructor(channels, size, 3 * points, code=7, hidden=(6, 5))
    operators = torch.randn(3, channels, size, size)
    assert net.encode(operators).shape == (3, 7)
    assert net(operators).shape == (3, points, 3)
    assert net(operators[:0]).shape == (0, points, 3)


def test_a_shape_is_its_code():
    torch.manual_seed(0)
    net, operators = Reconstructor(1, 10, 60), torch.randn(4, 1, 10, 10)
    code = net.encode(operators)
    assert code.min() >= 0  # after the ReLU, as the paper takes it
    torch.testing.assert_close(net.decode(code), net(operators))
    a, b, c = code[:1], code[1:2], code[2:3]
    torch.testing.assert_close(net.decode(c + a - a), net(operators[2:3]))
    assert net.decode(c + b - a).shape == (1, 20, 3)


def test_it_learns_two_clouds():
    """Down to a tenth of what the mean of the two clouds leaves."""
    torch.manual_seed(0)
    operators = torch.randn(2, 1, 10, 10)
    clouds = torch.rand(2, 64, 3) + torch.tensor([[[0.0, 0, 0]], [[2, 0, 0]]])
    net = Reconstructor(1, 10, 3 * 64)
    optimiser = torch.optim.Adam(net.parameters(), lr=0.005)
    for _ in range(300):
        optimiser.zero_grad()
        chamfer(net(operators), clouds).backward()
        optimiser.step()
    assert chamfer(net(operators), clouds) < 0.1 * chamfer(clouds.mean(0).expand(2, -1, -1), clouds)


def test_seed_makes_the_weights():
    def weights(seed):
        torch.manual_seed(seed)
        return torch.cat([p.flatten() for p in Reconstructor(1, 10, 9).parameters()])

    assert torch.equal(weights(0), weights(0))
    assert not torch.equal(weights(0), weights(1))


def test_outputs_are_points():
    with pytest.raises(InputError, match="outputs=10: expected three coordinates a point"):
        Reconstructor(1, 10, 10)
    with pytest.raises(InputError, match="outputs=0"):
        Reconstructor(1, 10, 0)
    with pytest.raises(InputError, match="layers: expected"):
        Reconstructor(1, 10, 9, layers=[[20, 3]])


def test_reads():
    assert reads(Reconstructor) == "operators"
    assert not is_solved(Reconstructor)
