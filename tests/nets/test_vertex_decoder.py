import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.learning import operator_features, split
from lssd_learn.learning.references.ridge import ALPHAS, Ridge
from lssd_learn.nets import VertexDecoder, is_solved, reads

SIZE, VERTICES = 5, 30


@pytest.fixture(scope="module")
def shapes():
    """Operators of 120 shapes and their vertices, which follow linearly from two directions of the logarithms."""
    generator = torch.Generator().manual_seed(0)

    def symmetric(n):
        X = torch.randn(n, 2, SIZE, SIZE, generator=generator, dtype=torch.float64)
        return 0.1 * (X + X.mT)

    logs, directions = symmetric(120), symmetric(2)
    numbers = torch.einsum("ncij,pcij->np", logs, directions)
    moves = torch.randn(2, 3 * VERTICES, generator=generator, dtype=torch.float64)
    vertices = 4 + numbers @ moves
    return torch.linalg.matrix_exp(logs), vertices


def solved(operators, vertices, train=90, **options):
    """The net after its last round, and the validation error after each."""
    net = VertexDecoder(operators.shape[1], operators.shape[2], vertices.shape[1], **options)
    rounds = net.solve((operators[:train], vertices[:train]), (operators[train:], vertices[train:]))
    return net, [float((predicted.flatten(1) - vertices[train:]).norm(dim=1).mean()) for _, predicted in rounds]


def test_it_reads_vertices(shapes):
    operators, vertices = shapes
    net, errors = solved(operators, vertices)
    assert is_solved(net)
    assert reads(VertexDecoder) == "operators"
    assert len(errors) == net.rounds
    spread = (vertices[90:] - vertices[:90].mean(0)).norm(dim=1).mean()
    assert errors[-1] < 0.05 * spread
    assert net(operators).shape == (120, VERTICES, 3)


def test_modes_are_orthonormal_and_hold_the_training_shapes(shapes):
    operators, vertices = shapes
    net, _ = solved(operators, vertices, rounds=1)
    assert len(net.modes) == 2  # of the forty allowed: there are no more
    torch.testing.assert_close(net.modes @ net.modes.T, torch.eye(2), atol=1e-5, rtol=0)
    torch.testing.assert_close(net.decode(net.coefficients).flatten(1).double(), vertices[:90], atol=1e-4, rtol=0)


def test_what_is_said_of_training_shapes_left_out_is_true(shapes):
    """The closed form of leaving one out, against doing so, the noise being given."""
    operators, vertices = shapes
    net, _ = solved(operators, vertices, rounds=1, neighbours=(0,), noises=(1e-3,), modes=2)
    kernel = torch.exp(-0.5 * torch.cdist(net.shapes, net.shapes) ** 2 * net.metrics[0][0, 0])
    missed = []
    for i in range(90):
        rest = [j for j in range(90) if j != i]
        weights = torch.linalg.solve(kernel[rest][:, rest] + 1e-3 * torch.eye(89), net.coefficients[rest])
        missed.append(net.coefficients[i] - kernel[i, rest] @ weights)
    missed = torch.stack(missed)
    torch.testing.assert_close(net.error, missed.T @ missed / 90, rtol=1e-4, atol=1e-9)


def test_a_shape_is_its_code(shapes):
    operators, vertices = shapes
    net, _ = solved(operators, vertices)
    codes = net.encode(operators)
    torch.testing.assert_close(net.decode(codes).double(), net(operators))
    a, b = codes[:1], codes[1:2]
    middle = (net.decode(a) + net.decode(b)) / 2
    torch.testing.assert_close(net.decode((a + b) / 2), middle, atol=1e-4, rtol=0)


def test_the_basis_of_the_latent_space_does_not_matter(shapes):
    operators, vertices = shapes
    Q = torch.linalg.qr(torch.randn(SIZE, SIZE, generator=torch.Generator().manual_seed(1), dtype=torch.float64))[0]
    turned = Q.T @ operators @ Q
    expected = solved(operators, vertices)[0](operators)
    assert torch.allclose(solved(turned, vertices)[0](turned), expected, atol=1e-3)


def test_a_net_is_its_state(shapes):
    operators, vertices = shapes
    net, _ = solved(operators, vertices, width=2.0)
    other = VertexDecoder(2, SIZE, 3 * VERTICES)
    assert other(operators).shape == (120, VERTICES, 3)  # unsolved, but of the right shape
    other.load_state_dict(net.state_dict())
    assert torch.equal(other(operators), net(operators))
    with pytest.raises(RuntimeError):
        VertexDecoder(2, SIZE, 3).load_state_dict(net.state_dict())


def test_single_precision_in_single_precision_out(shapes):
    operators, vertices = shapes
    net, _ = solved(operators, vertices)
    single = net(operators.float())
    assert single.dtype == torch.float32
    torch.testing.assert_close(single.double(), net(operators), atol=1e-3, rtol=0)


def test_shapes_that_are_all_alike_give_the_mean():
    operators, vertices = torch.eye(SIZE).repeat(4, 1, 1, 1), torch.arange(24.0).reshape(4, 6)
    net = VertexDecoder(1, SIZE, 6)
    *_, (train, _) = net.solve((operators, vertices), (operators, vertices))
    torch.testing.assert_close(train.flatten(1), vertices.mean(0).expand(4, -1))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"outputs": 10}, "outputs=10: expected three coordinates a vertex"),
        ({"outputs": 0}, "outputs=0"),
        ({"modes": 0}, "net.modes=0"),
        ({"neighbours": ()}, "net.neighbours: expected at least one"),
        ({"neighbours": (3, -1)}, "net.neighbours=-1"),
        ({"rounds": 0}, "net.rounds=0"),
    ],
)
def test_options_out_of_range(wrong, message):
    with pytest.raises(InputError, match=message):
        VertexDecoder(**({"channels": 1, "size": SIZE, "outputs": 9} | wrong))


def test_on_bodies_it_beats_ridge_and_knows_bodies_from_blends(many_bodies, body_meshes):
    latent = LatentSpace.fit(MapNetwork.clique(many_bodies[:]), 64, 40)
    operators = torch.stack(latent.differences(symmetric=True), dim=1)
    vertices = torch.tensor(np.stack([mesh.vertices.ravel() for mesh in body_meshes]))
    parts = split(len(many_bodies), 0)
    train, validation, test = ((operators[i], vertices[i]) for i in (parts.train, parts.validation, parts.test))

    def error(predicted):
        return float((predicted.double() - test[1].unflatten(1, (-1, 3))).norm(dim=2).mean())

    ridge = Ridge.fit(operator_features(operators), vertices.numpy(), parts.train)
    of_ridge = min(error(torch.tensor(ridge.at(parts.test, a)).unflatten(1, (-1, 3))) for a in ALPHAS)
    errors = []
    for choices in ((0,), (0, 5, 10, 20)):
        net = VertexDecoder(2, 40, vertices.shape[1], neighbours=choices)
        for _ in net.solve(train, validation):
            pass
        errors.append(error(net(test[0])))
    assert errors[0] < 0.8 * of_ridge
    assert errors[1] < 0.9 * errors[0]
