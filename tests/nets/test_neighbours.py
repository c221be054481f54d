import pytest
import torch

from lssd_learn.nets.neighbours import neighbour_graph, neighbours_maximum


def graph_plain(points, k):
    """All distances, sorted."""
    offsets = len(points[0]) * torch.arange(len(points)).view(-1, 1, 1)
    return (torch.cdist(points, points).argsort(-1)[..., :k] + offsets).flatten(0, 1)


def maximum_plain(values, graph):
    """The values of all neighbours at once."""
    return values.flatten(0, 1)[graph].amax(1).view_as(values)


def randn(*shape):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(0), dtype=torch.float64)


@pytest.mark.parametrize(
    ("n", "points", "channels", "k"), [(3, 640, 3, 20), (2, 1024, 32, 5), (2, 333, 4, 20), (5, 40, 3, 1), (2, 7, 3, 7)]
)
def test_neighbours_are_the_nearest(n, points, channels, k):
    clouds = randn(n, points, channels)
    graph = neighbour_graph(clouds, k)
    assert graph.shape == (n * points, k)
    assert torch.equal(graph.sort(-1).values, graph_plain(clouds, k).sort(-1).values)


def test_neighbours_are_found_in_single_precision_far_from_the_origin():
    clouds = randn(1, 320, 3)
    graph = neighbour_graph((clouds + 10).float(), 10)
    chosen, best = (
        (clouds[0, rows] - clouds[0].unsqueeze(1)).norm(dim=-1) for rows in (graph, graph_plain(clouds, 10))
    )
    assert (chosen.amax(1) - best.amax(1)).max() < 1e-3


def test_alike_points_are_neighbours_of_each_other():
    graph = neighbour_graph(torch.zeros(2, 320, 3), 20)
    assert all(len(set(row.tolist())) == 20 for row in graph)
    assert torch.equal(graph // 320, torch.arange(640).view(-1, 1) // 320 * torch.ones(20, dtype=torch.long))


@pytest.mark.parametrize(("n", "points", "k"), [(3, 320, 20), (1, 50, 1), (2, 7, 7)])
def test_the_maximum_and_its_gradient_are_those_of_the_plain_way(n, points, k):
    values, graph = randn(n, points, 6).requires_grad_(), neighbour_graph(randn(n, points, 3), k)
    weights = randn(n, points, 6)
    fast, plain = (maximum(values, graph) for maximum in (neighbours_maximum, maximum_plain))
    assert torch.equal(fast, plain)
    gradients = [torch.autograd.grad((result * weights).sum(), values)[0] for result in (fast, plain)]
    torch.testing.assert_close(*gradients)


def test_of_equal_values_one_gets_the_gradient():
    values, graph = torch.zeros(1, 9, 2, requires_grad=True), neighbour_graph(randn(1, 9, 3), 4)
    neighbours_maximum(values, graph).sum().backward()
    assert values.grad.sum() == 18
    assert torch.equal(values.grad, values.grad.round())


def test_what_is_not_a_number_breaks_nothing():
    clouds = torch.full((1, 30, 3), torch.nan)
    assert neighbours_maximum(clouds, neighbour_graph(clouds, 4)).isnan().all()


def test_no_clouds():
    graph = neighbour_graph(torch.zeros(0, 30, 3), 4)
    assert graph.shape == (0, 4)
    assert neighbours_maximum(torch.zeros(0, 30, 5), graph).shape == (0, 30, 5)
