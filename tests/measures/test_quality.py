"""`task=map_quality` and `task=network_quality`: computed maps against the true ones of remeshed bodies."""

import csv

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.measures.map_quality import choose_pairs
from lssd_learn.measures.network_quality import operator_errors
from lssd_learn.view.errors import cumulative_chart

REMESHED = (
    "collection=remeshed",
    "collection.base.topology=notoes_collapse5pc",
    "collection.base.n=9",
    "collection.vertices=[400,500]",
    "basis.k=30",
    "latent.size=12",
    "latent.keep=10",
    "parallel.workers=1",
)


@pytest.fixture(scope="module")
def program(pieces_of, tmp_path_factory):
    """A function (out, overrides) → the metrics of a run of this process, on one cache."""
    cache = tmp_path_factory.mktemp("quality") / "cache"

    def run(out, *overrides):
        pieces = pieces_of(out, *overrides, f"cache={cache}")
        return pieces.task(pieces, out)

    return run


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_methods_are_scored_on_three_kinds_of_pairs(program, tmp_path):
    metrics = program(
        tmp_path, *REMESHED, "task=map_quality", "task.pairs=1", "collection.marks=8",
        "task.methods=[kernel_matching,registration,landmarks,adjoint]",
    )  # fmt: skip
    table = rows(tmp_path / "map_errors.csv")
    assert len(table) == 12
    assert {row["kind"] for row in table} == {"neighbours", "same_pose", "other_pose"}
    assert {row["source"] for row in table if row["kind"] == "same_pose"} <= {"body_0000", "body_0008"}
    for name in ("kernel_matching", "registration", "landmarks", "adjoint"):
        for kind in ("neighbours", "same_pose", "other_pose"):
            (row,) = [row for row in table if (row["method"], row["kind"]) == (name, kind)]
            for score in ("error", "flipped"):
                assert metrics[f"{name}/{kind}/{score}"] == pytest.approx(float(row[score]), abs=1e-4)
        assert metrics[f"{name}/same_pose/error"] < 0.2  # a random map: about .5
        assert metrics[f"{name}/seconds"] > 0
    assert metrics["registration/same_pose/error"] < 0.06
    assert (tmp_path / "map_errors.png").stat().st_size > 5000


def test_the_operators_of_a_network_are_scored(program, tmp_path):
    arguments = (*REMESHED, "task=network_quality", "maps=kernel_matching", "network=hubs", "network.hubs=2")
    metrics = program(tmp_path, *arguments, "task.refine=[10,20,10]")
    assert (metrics["shapes"], metrics["edges"]) == (9, 15)
    table = rows(tmp_path / "operator_errors.csv")
    assert np.median([float(row["error"]) for row in table]) == pytest.approx(metrics["error/median"], abs=1e-4)
    assert max(float(row["error"]) for row in table) == pytest.approx(metrics["error/worst"], abs=1e-4)
    assert metrics["error/median"] < 1  # the spread of the operators: what the identity everywhere would have
    assert {"name", "error", "refined"} == set(table[0])
    assert (tmp_path / "operator_errors.png").stat().st_size > 5000


@pytest.mark.parametrize("task", ["map_quality", "network_quality"])
def test_unknown_truths_are_refused(program, tmp_path, task):
    with pytest.raises(InputError, match="expected a collection whose true maps are known: collection=remeshed"):
        program(tmp_path, "collection=bodies_small", "collection.n=2", "basis.k=5", "latent.size=4", "latent.keep=3",
                f"task={task}", "maps=registration")  # fmt: skip


def test_bad_choices_are_refused(program, tmp_path):
    with pytest.raises(InputError, match="task.methods: expected some of auto, kernel_matching, .* got magic"):
        program(tmp_path, *REMESHED, "task=map_quality", "task.methods=[magic]")
    with pytest.raises(InputError, match="expected maps that are computed, such as maps=kernel_matching"):
        program(tmp_path, *REMESHED, "task=network_quality", "maps=correspondence")


def test_errors_do_not_depend_on_the_basis_and_are_relative_to_the_spread():
    generator = torch.Generator().manual_seed(0)
    Y = torch.eye(12, 6).double() + 0.1 * torch.randn(5, 12, 6, generator=generator, dtype=torch.float64)
    Q = torch.linalg.qr(torch.randn(6, 6, generator=generator, dtype=torch.float64))[0]
    assert operator_errors(Y @ Q, Y).max() < 1e-10
    spread = np.sqrt(np.mean([torch.linalg.norm(y.T @ y - torch.eye(6)).item() ** 2 for y in Y]))
    bent = Y.clone()
    bent[2] *= 1.1
    expected = 0.21 * torch.linalg.norm(Y[2].T @ Y[2]).item() / spread
    assert operator_errors(bent, Y)[2] == pytest.approx(expected, rel=0.02)


def test_pairs_without_poses_are_neighbours():
    class Nameless:
        groups = {}

        def __len__(self):
            return 3

    pairs = choose_pairs(Nameless(), np.array([[0, 1.0], [0, 1.1], [0, 5.0]]), 5, 0)
    assert sorted(pairs) == [("neighbours", 0, 1), ("neighbours", 1, 0), ("neighbours", 1, 2)]


def test_a_chart_of_equal_errors():
    figure = cumulative_chart({"none": [0, 0], "some": [0.1, 0.3]}, "error")
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == [
        "none, median 0",
        "some, median 0.2",
    ]
