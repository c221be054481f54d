import pytest
import torch

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.learning import operator_features, ridge_reference, split
from lssd_learn.nets import KernelMachine, is_solved
from lssd_learn.nets.kernel import gaussian, rehearsed_noise
from lssd_learn.operators.vectors import log_features

SIZE = 6


def symmetric(n, generator):
    X = torch.randn(n, 2, SIZE, SIZE, generator=generator, dtype=torch.float64)
    return 0.2 * (X + X.mT)


@pytest.fixture(scope="module")
def shapes():
    """160 pairs of operators near the identity, and two numbers that follow, not linearly, from two directions."""
    generator = torch.Generator().manual_seed(0)
    logs, directions = symmetric(160, generator), symmetric(2, generator)
    targets = torch.sin(0.6 * torch.einsum("ncij,pcij->np", logs, directions))
    return torch.linalg.matrix_exp(logs), targets


def solved(operators, targets, train=120, **options):
    """The machine after its last round, and the validation error after each."""
    net = KernelMachine(operators.shape[1], operators.shape[2], targets.shape[1], **options)
    rounds = net.solve((operators[:train], targets[:train]), (operators[train:], targets[train:]))
    return net, [float(((predicted - targets[train:]) ** 2).mean()) for _, predicted in rounds]


def test_it_finds_the_directions_that_matter(shapes):
    net, errors = solved(*shapes)
    assert is_solved(KernelMachine)
    assert is_solved(net)
    assert len(errors) == net.rounds
    assert errors[-1] < 0.01 * errors[0]
    evals = torch.linalg.eigvalsh(net.metrics[0])
    assert evals[-1] > 0.9 * evals.sum()  # of 42 directions, one


def test_without_noise_it_interpolates(shapes):
    operators, targets = shapes
    net, _ = solved(operators, targets, noises=(1e-12,), rounds=2)
    assert torch.allclose(net(operators[:120]), targets[:120], atol=1e-6)


def test_bounds_are_those_of_the_training_shapes(shapes):
    operators, targets = shapes
    free, _ = solved(operators, targets, bounded=False)
    net, _ = solved(operators, targets)
    far = torch.linalg.matrix_power(operators, 3)
    lowest, highest = targets[:120].amin(0), targets[:120].amax(0)
    assert (free(far) > highest).any()
    assert torch.equal(net(far), free(far).clamp(lowest, highest))
    again = KernelMachine(2, SIZE, 2)  # whatever its options
    again.load_state_dict(net.state_dict())
    assert torch.equal(again(far), net(far))


def test_the_basis_of_the_latent_space_does_not_matter(shapes):
    operators, targets = shapes
    generator = torch.Generator().manual_seed(1)
    Q = torch.linalg.qr(torch.randn(SIZE, SIZE, generator=generator, dtype=torch.float64))[0]
    S = torch.diag(torch.tensor([1.0, -1, -1, 1, 1, -1], dtype=torch.float64))
    expected = solved(operators, targets)[0](operators)
    for turn in (Q, S):
        turned = turn.T @ operators @ turn
        assert torch.allclose(solved(turned, targets)[0](turned), expected, atol=1e-5)


def test_null_functions_are_left_out(shapes):
    operators, targets = shapes
    wider = torch.zeros(len(operators), 2, SIZE + 1, SIZE + 1, dtype=torch.float64)
    wider[:, :, 1:, 1:] = operators
    assert torch.allclose(solved(wider, targets)[0](wider), solved(operators, targets)[0](operators), atol=1e-8)


def test_targets_may_be_shifted_and_scaled(shapes):
    operators, targets = shapes
    shifted = solved(operators, 3 * targets + 7)[0](operators)
    assert torch.allclose(shifted, 3 * solved(operators, targets)[0](operators) + 7, atol=1e-8)


def test_a_machine_is_its_state(shapes):
    operators, targets = shapes
    net, _ = solved(operators, targets, width=2.0)
    other = KernelMachine(2, SIZE, 2)
    other.load_state_dict(net.state_dict())
    assert torch.equal(other(operators), net(operators))
    with pytest.raises(RuntimeError):
        KernelMachine(1, SIZE, 2).load_state_dict(net.state_dict())


def test_single_precision_in_single_precision_out(shapes):
    operators, targets = shapes
    net, _ = solved(operators, targets)
    single = net(operators.float())
    assert single.dtype == torch.float32
    assert torch.allclose(single.double(), net(operators), atol=1e-3)


def test_shapes_that_are_all_alike_give_the_mean():
    operators, targets = torch.eye(SIZE).repeat(4, 1, 1, 1), torch.arange(4.0)[:, None]
    net = KernelMachine(1, SIZE, 1)
    *_, (train, _) = net.solve((operators, targets), (operators, targets))
    assert torch.allclose(train, torch.tensor(1.5, dtype=torch.float64))


def test_with_all_shapes_as_centres_it_is_the_exact_machine(shapes):
    operators, targets = shapes
    options = {"rounds": 3, "noises": (1e-4, 1e-2)}
    exact, errors = solved(operators, targets, **options)
    many, others = solved(operators, targets, **options, exact=100, centres=120)
    assert torch.allclose(many(operators), exact(operators), atol=1e-4)
    assert others == pytest.approx(errors, rel=1e-2)


def test_some_centres_are_fitted_to_all_shapes(shapes):
    operators, targets = shapes
    exact, errors = solved(operators, targets)
    many, others = solved(operators, targets, exact=100, centres=60)
    _, alone = solved(torch.cat([operators[:60], operators[120:]]), torch.cat([targets[:60], targets[120:]]), train=60)
    assert many.shapes.shape[0] == 60
    assert errors[-1] < others[-1] < 0.7 * alone[-1]
    again = KernelMachine(2, SIZE, 2)
    again.load_state_dict(many.state_dict())
    assert torch.equal(again(operators), many(operators))


def test_its_ridge_is_the_same_of_many_shapes(shapes):
    operators, targets = shapes
    exact, many = (solved(operators, targets, rounds=1, exact=exact)[0] for exact in (5000, 100))
    x = exact._components(operators)  # of principal directions, each is known but for its sign
    assert torch.allclose(x @ exact.ridge, many._components(operators) @ many.ridge, atol=1e-6)


@pytest.mark.parametrize(
    "wrong", [{"exact": 0}, {"centres": 1}, {"rounds": 0}, {"width": 0.0}, {"floor": -1.0}, {"components": 0}]
)
def test_options_out_of_range(wrong):
    with pytest.raises(InputError, match=f"net.{next(iter(wrong))}="):
        KernelMachine(1, SIZE, 1, **wrong)


def test_on_bodies_it_beats_ridge(many_bodies):
    latent = LatentSpace.fit(MapNetwork.clique(many_bodies[:]), 64, 40)
    operators = torch.stack(latent.differences(symmetric=True), dim=1)
    parameters = torch.tensor(Bodies(n=len(many_bodies), topology="notoes_collapse5pc").parameters)
    parts = split(len(many_bodies), 0)
    ridge = ridge_reference(operator_features(operators), parameters.numpy(), parts)
    train, validation, test = ((operators[i], parameters[i]) for i in (parts.train, parts.validation, parts.test))
    net = KernelMachine(2, 40, 12)
    for _ in net.solve(train, validation):
        pass
    assert ((net(test[0]) - test[1]) ** 2).mean() < 0.8 * ridge.mse


def test_the_noise_is_chosen_on_validation(shapes):
    """Targets with errors of their own: on the training shapes the least noise fits best, on others it does not."""
    operators, targets = shapes
    noisy = targets[:, :1] + 1.0 * torch.randn(len(targets), 1, generator=torch.Generator().manual_seed(2)).double()
    candidates = (1e-8, 1e-2, 1.0, 10.0)
    each = [solved(operators, noisy, rounds=1, noises=(noise,))[1][0] for noise in candidates]
    assert min(each) < 0.9 * each[0]
    assert solved(operators, noisy, rounds=1, noises=candidates)[1][0] == pytest.approx(min(each))


def test_the_first_round_is_a_gaussian_kernel_of_the_stated_width(shapes):
    operators, targets = shapes
    net, _ = solved(operators, targets, rounds=1, width=2.0, noises=(1e-3,), bounded=False)
    logarithms = log_features(operators, net.live)
    train = logarithms[:120]
    spread = ((train - train.mean(0)) ** 2).sum(1).mean()
    kernel = torch.exp(-(torch.cdist(logarithms, train) ** 2) / (2 * 2.0**2 * spread))
    mean = targets[:120].mean(0)
    noisy = kernel[:120] + 1e-3 * torch.eye(120, dtype=torch.float64)
    expected = mean + kernel @ torch.linalg.solve(noisy, targets[:120] - mean)
    assert torch.allclose(net(operators), expected, atol=1e-7)


def test_beyond_training_a_ridge_answers():
    """An output that is linear in the logarithms, asked for beyond its range in training, is a ridge's; one that is
    not linear, and asked for within, stays the kernel's."""
    generator = torch.Generator().manual_seed(5)
    logs = torch.zeros(200, 3, 3, dtype=torch.float64)
    at = 2 * torch.rand(200, 3, generator=generator, dtype=torch.float64) - 1
    at[150:, 0] += 2.5  # validation and test lie beyond
    logs[:, range(3), range(3)] = at
    operators = torch.linalg.matrix_exp(logs)[:, None]
    targets = torch.stack([at[:, 0], torch.cos(3 * at[:, 1])], dim=1)
    targets[:, 1] *= at[:, 0] < 9
    net = KernelMachine(1, 3, 2)
    for _ in net.solve((operators[:150], targets[:150]), (operators[150:175], targets[150:175])):
        pass
    assert net.linear.tolist() == [True, False]
    assert (net(operators[175:])[:, 0] - targets[175:, 0]).abs().max() < 0.05
    again = KernelMachine(1, 3, 2)
    again.load_state_dict(net.state_dict())
    assert torch.equal(again(operators), net(operators))
    old = {name: value for name, value in net.state_dict().items() if name not in ("linear", "ridge")}
    again.load_state_dict(old)  # of a machine solved before there was a ridge
    assert again(operators[175:])[:, 0].max() <= targets[:150, 0].max()


def test_what_is_rehearsed_is_chosen_on_blocks_left_out():
    """Each block adds something of its own to the logarithms, half of it along what is to be read."""
    generator = torch.Generator().manual_seed(6)
    logs, directions = symmetric(240, generator), symmetric(2, generator)
    blocks = torch.arange(240) % 8
    own = 3 * symmetric(8, generator)
    own[:, 0] += torch.randn(8, 1, 1, generator=generator).double() * directions[0, 0]
    operators = torch.linalg.matrix_exp(logs + own[blocks])
    targets = torch.einsum("ncij,pcij->np", logs, directions)
    known, unseen = blocks < 6, blocks == 7
    errors = {}
    for rehearsed in (True, False):
        net = KernelMachine(2, SIZE, 2, rounds=2)
        validation = known & (torch.arange(240) % 3 == 0)
        train = known & ~validation
        given = {"blocks": blocks[train]} if rehearsed else {}
        for _ in net.solve((operators[train], targets[train]), (operators[validation], targets[validation]), **given):
            pass
        errors[rehearsed] = float((net(operators[unseen]) - targets[unseen]).square().mean())
    assert errors[True] < 0.8 * errors[False]
    with pytest.raises(InputError, match="^data.rehearse: expected training shapes of two labels or more, got one"):
        next(net.solve((operators, targets), (operators, targets), torch.zeros(240).long()))


def test_rehearsal_against_a_loop():
    generator = torch.Generator().manual_seed(7)
    x, target = torch.randn(30, 4, generator=generator).double(), torch.randn(30, generator=generator).double()
    blocks, noises = torch.arange(30) // 10, torch.tensor([1e-3, 1e-2, 1e-1, 1.0]).double()
    kernel, errors = gaussian(x, x, torch.eye(4).double()), []
    for noise in noises:
        error = 0.0
        for block in range(3):
            some, out = blocks != block, blocks == block
            weights = torch.linalg.solve(kernel[some][:, some] + noise * torch.eye(20), target[some])
            found = (kernel[out][:, some] @ weights).clamp(target.min(), target.max())
            error += float((found - target[out]).square().sum())
        errors.append(error)
    assert int(rehearsed_noise(kernel, noises, target, blocks)) == errors.index(min(errors))
