import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.nets import CNN, Autoencoder, Reconstructor, VertexDecoder, chamfer, reads, writes


@pytest.fixture
def clouds():
    return torch.rand(4, 64, 3, generator=torch.Generator().manual_seed(0))


def test_the_order_and_number_of_points_do_not_matter(clouds):
    torch.manual_seed(0)
    net = Autoencoder(3, 64, 3 * 50)
    assert net(clouds).shape == (4, 50, 3)
    torch.testing.assert_close(net(clouds.flip(1)), net(clouds))
    torch.testing.assert_close(net(clouds.repeat(1, 2, 1)), net(clouds))
    torch.testing.assert_close(net.decode(net.encode(clouds)), net(clouds))
    assert (net.encode(clouds) >= 0).all()


def test_it_learns_to_draw_what_it_sees(clouds):
    torch.manual_seed(0)
    net = Autoencoder(3, 64, 3 * 64)
    adam = torch.optim.Adam(net.parameters(), 0.005)
    first = chamfer(net(clouds), clouds).detach()
    for _ in range(60):
        adam.zero_grad()
        loss = chamfer(net(clouds), clouds)
        loss.backward()
        adam.step()
    assert loss < 0.2 * first


def test_what_nets_give():
    assert (reads(Autoencoder), writes(Autoencoder)) == ("clouds", "clouds")
    assert [writes(net) for net in (CNN, Reconstructor, VertexDecoder)] == ["numbers", "clouds", "vertices"]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"outputs": 10}, "outputs=10"), ({"encoder": ()}, "net.encoder"), ({"encoder": (4, 0)}, "net.encoder=0")],
)
def test_options_out_of_range(wrong, message):
    with pytest.raises(InputError, match=message):
        Autoencoder(**({"channels": 3, "size": 9, "outputs": 9} | wrong))
