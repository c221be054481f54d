import numpy as np
import pytest
import torch

from lssd_learn.learning.batches import Batches, Order, Variation, turned


def positions(order):
    return [batch.tolist() for batch in order]


def test_every_sample_once_an_epoch():
    order = Order(23, 5, seed=0)
    batches = positions(order)
    assert [len(batch) for batch in batches] == [5, 5, 5, 5, 3]
    assert len(order) == 5
    assert sorted(sum(batches, [])) == list(range(23))


def test_order_follows_from_seed_and_epoch_alone():
    a, b, other = Order(40, 8, seed=0), Order(40, 8, seed=0), Order(40, 8, seed=1)
    first = positions(a)
    a.set_epoch(7)
    b.set_epoch(7)
    other.set_epoch(6)
    assert positions(a) == positions(a) == positions(b)
    assert positions(a) != first
    assert positions(a) != positions(other)  # seed + epoch would make these two the same


def test_without_a_seed_nothing_is_shuffled():
    assert positions(Order(5, 2)) == [[0, 1], [2, 3], [4]]


@pytest.mark.parametrize("world", [2, 3, 7])
def test_processes_share_every_batch_equally(world):
    whole = positions(Order(23, 6, seed=3))
    shares = [positions(Order(23, 6, seed=3, rank=rank, world=world)) for rank in range(world)]
    for i, batch in enumerate(whole):
        sizes = {len(share[i]) for share in shares}
        assert sizes == {-(-len(batch) // world)}
        assert set(sum((share[i] for share in shares), [])) == set(batch)


def test_batches_index_all_tensors_alike():
    x = torch.arange(20.0)
    for a, b in Batches(Order(20, 6, seed=0), x, 2 * x):
        assert torch.equal(b, 2 * a)


def test_two_passes_are_independent_of_the_global_generators():
    def one_pass():
        return torch.cat([x for (x,) in Batches(Order(20, 6, seed=0), torch.arange(20))])

    first = one_pass()
    np.random.default_rng()
    torch.rand(3)
    assert torch.equal(one_pass(), first)


@pytest.fixture
def clouds():
    """12 clouds of 40 points, and ten times denser ones; cloud i lies around (i, i, i)."""
    generator = torch.Generator().manual_seed(0)
    return tuple(
        0.1 * torch.randn(12, many, 3, generator=generator) + torch.arange(12.0).view(-1, 1, 1) for many in (40, 400)
    )


def epoch_of(clouds, vary, epoch, world=1):
    """Shape → its cloud in an epoch, of all processes together."""
    seen = {}
    for rank in range(world):
        batches = Batches(Order(len(clouds), 5, 3, rank, world), clouds, torch.arange(len(clouds)), vary=vary)
        batches.sampler.set_epoch(epoch)
        for some, shapes in batches:
            for shape, cloud in zip(shapes.tolist(), some, strict=True):
                assert torch.equal(seen.setdefault(shape, cloud), cloud)
    return torch.stack([seen[shape] for shape in range(len(clouds))])


@pytest.mark.parametrize(("up", "resample"), [("z", False), (None, True), ("y", True)])
def test_a_varied_cloud_follows_from_seed_epoch_and_shape_alone(clouds, up, resample):
    plain, denser = clouds
    vary, other = (Variation(seed, up, denser if resample else None) for seed in (3, 4))
    first = epoch_of(plain, vary, 7)
    assert first.shape == plain.shape
    assert torch.equal(epoch_of(plain, vary, 7), first)
    assert torch.equal(epoch_of(plain, vary, 7, world=2), first)
    assert torch.equal(epoch_of(plain, vary, 7, world=3), first)
    for changed in (epoch_of(plain, vary, 6), epoch_of(plain, other, 7), plain):
        assert (changed != first).any(-1).any(-1).all()
    assert torch.equal(torch.stack([cloud.mean().round() for cloud in first]), torch.arange(12.0))


def test_points_are_drawn_from_the_denser_cloud_each_at_most_once(clouds):
    plain, denser = clouds
    for cloud, pool in zip(epoch_of(plain, Variation(0, denser=denser), 2), denser, strict=True):
        hits = (cloud.unsqueeze(1) == pool).all(-1)
        assert torch.equal(hits.sum(1), torch.ones(40))
        assert hits.sum(0).max() == 1


def test_all_points_of_a_denser_cloud_are_drawn_in_time(clouds):
    plain, denser = clouds
    vary = Variation(0, denser=denser)
    drawn = torch.cat([vary(plain[:1], torch.tensor([0]), epoch)[0] for epoch in range(100)])
    times = (drawn.unsqueeze(1) == denser[0]).all(-1).sum(0)
    assert times.min() > 0
    assert times.sum() == 4000


def test_a_turn_by_hand():
    cloud = torch.tensor([[[1.0, 2.0, 3.0], [-1.0, -2.0, -3.0]]])
    quarter = torch.tensor([torch.pi / 2])
    for axis, expected in (("z", [-2.0, 1.0, 3.0]), ("y", [3.0, 2.0, -1.0]), ("x", [1.0, -3.0, 2.0])):
        result = turned(cloud, quarter, axis)
        torch.testing.assert_close(result[0], torch.tensor([expected, [-x for x in expected]]))
        torch.testing.assert_close(turned(cloud + 5, quarter, axis), result + 5)  # it turns where it stands


def test_turns_are_rigid_about_the_axis_that_is_up_and_of_any_angle(clouds):
    plain, _ = clouds
    angles = []
    for epoch in range(40):
        result = epoch_of(plain, Variation(0, "y"), epoch)
        torch.testing.assert_close(result[..., 1], plain[..., 1])
        torch.testing.assert_close(result.mean(1), plain.mean(1))
        torch.testing.assert_close(*(torch.cdist(x.double(), x.double()) for x in (result, plain)), atol=1e-4, rtol=0)
        before, after = (x[:, 0, ::2] - x.mean(1)[:, ::2] for x in (plain, result))
        angles.append(torch.atan2(after[:, 1], after[:, 0]) - torch.atan2(before[:, 1], before[:, 0]))
    mean = torch.polar(torch.ones(480), torch.cat(angles)).mean()
    assert mean.abs() < 0.1


def test_some_shapes_are_counted_anew(clouds):
    plain, denser = clouds
    positions = np.array([2, 5, 11])
    few = Variation(0, denser=denser).among(positions)
    assert torch.equal(few.denser, denser[positions])
    assert Variation(0, "z").among(positions) == Variation(0, "z")
