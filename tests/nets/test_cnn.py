import math

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.nets import CNN, reads
from lssd_learn.nets.cnn import SameConv


def same_convolution(image, weight, bias, stride):
    """TensorFlow's "same" convolution by its definition, one output at a time."""
    filters, channels, kernel, _ = weight.shape
    size = image.shape[-1]
    out = math.ceil(size / stride)
    before = max((out - 1) * stride + kernel - size, 0) // 2
    result = np.zeros((filters, out, out))
    for f, i, j in np.ndindex(filters, out, out):
        total = bias[f]
        for c, a, b in np.ndindex(channels, kernel, kernel):
            row, column = i * stride + a - before, j * stride + b - before
            if 0 <= row < size and 0 <= column < size:
                total += weight[f, c, a, b] * image[c, row, column]
        result[f, i, j] = total
    return result


@settings(max_examples=40, deadline=None)
@given(size=st.integers(1, 9), kernel=st.integers(1, 5), stride=st.integers(1, 3), channels=st.integers(1, 2))
def test_padding_is_that_of_tensorflow(size, kernel, stride, channels):
    torch.manual_seed(0)
    layer = SameConv(channels, 2, kernel, stride).double()
    image = torch.randn(1, channels, size, size, dtype=torch.float64)
    expected = same_convolution(image[0].numpy(), layer.weight.detach().numpy(), layer.bias.detach().numpy(), stride)
    result = layer(image)[0].detach().numpy()
    assert result.shape == (2, math.ceil(size / stride), math.ceil(size / stride))
    np.testing.assert_allclose(result, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("size", "parameters"), [(5, 2202), (10, 2802), (20, 13672), (30, 9402), (40, 13722), (50, 22072)]
)
def test_number_of_parameters(size, parameters):
    net = CNN(1, size, 12)
    assert sum(p.numel() for p in net.parameters()) == parameters
    assert net(torch.randn(3, 1, size, size)).shape == (3, 12)


def test_kernels_of_the_paper():
    kernels = {
        m: [(c.kernel_size, c.stride) for c in CNN(1, m, 12).features if isinstance(c, SameConv)] for m in (20, 40, 50)
    }
    assert kernels[20] == [((2, 2), (1, 1)), ((4, 4), (2, 2))]
    assert kernels[40] == [((3, 3), (2, 2)), ((4, 4), (2, 2))]
    assert kernels[50] == [((4, 4), (2, 2)), ((4, 4), (2, 2))]


@pytest.mark.parametrize(("channels", "size"), [(2, 40), (1, 17), (2, 1)])
def test_any_size_and_two_channels(channels, size):
    assert CNN(channels, size, 8)(torch.randn(2, channels, size, size)).shape == (2, 8)


def test_no_shapes_give_no_predictions():
    assert CNN(1, 40, 12)(torch.zeros(0, 1, 40, 40)).shape == (0, 12)


def test_given_layers():
    net = CNN(1, 40, 12, layers=[[20, 3, 2], [20, 6, 2]])
    assert [c.out_channels for c in net.features if isinstance(c, SameConv)] == [20, 20]
    assert net(torch.randn(2, 1, 40, 40)).shape == (2, 12)


def test_final_relu_is_an_option():
    torch.manual_seed(0)
    x = torch.randn(20, 1, 10, 10)
    assert CNN(1, 10, 12, final_relu=True)(x).min() == 0
    assert CNN(1, 10, 12)(x).min() < 0


def test_functions_in_a_random_order():
    torch.manual_seed(0)
    net = CNN(1, 10, 3, permute=5)
    plain = CNN(1, 10, 3)
    plain.load_state_dict({name: value for name, value in net.state_dict().items() if name != "order"})
    x, order = torch.randn(4, 1, 10, 10), net.order
    assert torch.equal(order.sort().values, torch.arange(10))
    assert not torch.equal(order, torch.arange(10))
    torch.testing.assert_close(net(x), plain(x[:, :, order][:, :, :, order]))
    assert torch.equal(CNN(1, 10, 3, permute=5).order, order)


def test_memory_order_changes_no_number():
    torch.manual_seed(0)
    net, x = CNN(2, 40, 12).double(), torch.randn(3, 2, 40, 40, dtype=torch.float64)
    expected = net(x)
    net.features.to(memory_format=torch.contiguous_format)
    torch.testing.assert_close(net(x), expected)


def test_seed_makes_the_weights():
    def weights(seed):
        torch.manual_seed(seed)
        return torch.cat([p.flatten() for p in CNN(1, 10, 3).parameters()])

    assert torch.equal(weights(0), weights(0))
    assert not torch.equal(weights(0), weights(1))


def test_reads():
    assert reads(CNN) == reads(CNN(1, 5, 1)) == "operators"
