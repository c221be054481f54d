"""`task=analogy`, `task=analogy_benchmark` and `task=interpolation`: algebra on operators, drawn by a trained net."""

import csv

import numpy as np
import pytest
import torch

from lssd_learn.collections import POSE_NAMES, Bodies
from lssd_learn.collections.regions import region_mask
from lssd_learn.errors import InputError
from lssd_learn.measures.quadruples import draw_quadruples
from lssd_learn.models.synthesis import METHODS, answer, choose, open_trained, operators_of
from lssd_learn.shapes import PointCloud, load
from lssd_learn.tasks.interpolation import smoothness

BODIES = ("collection=bodies_small", "collection.n=40")
SMALL = (*BODIES, "task=reconstruction", "basis.k=40", "latent.size=32", "latent.keep=24", "task.points=128")
BOTH = "latent.operators=[area,conformal]"


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("synthesis")


@pytest.fixture(scope="module")
def pieces(pieces_of, common_cache):
    """A function (out, overrides) → the pieces of a run, on one cache."""

    def make(out, *overrides):
        return pieces_of(out, *overrides, f"cache={common_cache}")

    return make


@pytest.fixture(scope="module")
def program(pieces):
    def run(out, *overrides):
        made = pieces(out, *overrides)
        return made.task(made, out)

    return run


@pytest.fixture(scope="module")
def vertices(home, program):
    """A checkpoint of net=vertices."""
    program(home / "vertices", *SMALL, BOTH, "net=vertices", "net.rounds=2")
    return home / "vertices" / "best.ckpt"


@pytest.fixture(scope="module")
def cloud(home, program):
    """A checkpoint of net=reconstructor, hardly trained."""
    program(home / "cloud", *SMALL, "task.epochs=2")
    return home / "cloud" / "best.ckpt"


def test_an_analogy_with_a_known_answer_is_drawn_and_scored(program, vertices, tmp_path):
    names = ("task.a=body_0010:rest", "task.b=body_0010:t_pose", "task.c=body_0008:rest")
    metrics = program(tmp_path, "task=analogy", f"ckpt_path={vertices}", *BODIES, *names, "task.region=upper_body")
    assert metrics["answers"] == 4
    titles = [*METHODS, "P1", "P2", *(f"{x}{y}" for x in ("A", "B", "C", "truth") for y in ("", "_drawn"))]
    assert {path.name for path in (tmp_path / "shapes").iterdir()} == {
        f"{t}.{s}" for t in titles for s in ("ply", "glb")
    }
    bodies = Bodies(40, topology="notoes_collapse5pc")
    truth = bodies.make(bodies.parameters[8], "t_pose")
    np.testing.assert_allclose(load(tmp_path / "shapes" / "truth.ply").vertices, truth.vertices, atol=1e-6)
    for name in (*METHODS, "own"):  # scored is what was written
        drawn = load(tmp_path / "shapes" / f"{'truth_drawn' if name == 'own' else name}.ply").vertices
        off = 1000 * np.linalg.norm(drawn - truth.vertices, axis=1).mean()
        assert metrics[f"{name}/vertex_error_mm"] == pytest.approx(off, rel=1e-4)
    assert (tmp_path / "analogy.png").read_bytes()[:4] == b"\x89PNG"


def test_an_analogy_without_an_answer_and_a_net_that_gives_clouds(program, cloud, tmp_path, caplog):
    with caplog.at_level("INFO"):
        arguments = ("task.a=body_0000", "task.b=body_0001", "task.c=body_0002", "task.region=[1,2,3,4,5,6,7,8]")
        metrics = program(tmp_path, "task=analogy", f"ckpt_path={cloud}", *BODIES, *arguments)
    assert metrics == {"answers": 4}
    assert "no truth" in caplog.text
    assert isinstance(load(tmp_path / "shapes" / "multiplicative.ply"), PointCloud)


def test_what_is_to_a_as_b_to_a_is_b(pieces, vertices, tmp_path):
    made = pieces(tmp_path, "task=analogy", "task.a=x", "task.b=x", "task.c=x", f"ckpt_path={vertices}", *BODIES)
    trained = open_trained(made.ckpt_path, made.net, made.pipeline.cache, "analogy")
    D = torch.stack(trained.latent.differences(symmetric=True), dim=1)
    A, B, C = D[:5], D[5:10], D[10:15]
    with torch.no_grad():
        for method in METHODS:
            expected = trained.learner(B.float())
            torch.testing.assert_close(answer(trained.learner, method, A, B, A), expected, atol=2e-3, rtol=0)
            torch.testing.assert_close(
                answer(trained.learner, method, A, A, C), trained.learner(C.float()), atol=2e-3, rtol=0
            )


def test_known_shapes_keep_their_operators_and_others_are_pushed(pieces, vertices, tmp_path):
    made = pieces(tmp_path, "task=analogy", "task.a=x", "task.b=x", "task.c=x", f"ckpt_path={vertices}", *BODIES)
    trained = open_trained(made.ckpt_path, made.net, made.pipeline.cache, "analogy")
    asked = {"task.a": "body_0003", "task.b": "body_0003:sitting", "task.c": "body_0004:rest"}
    operators = operators_of(trained, choose(made.pipeline.collection, asked), made.pipeline, 5)
    area = trained.latent.differences()[0]
    torch.testing.assert_close(operators[0, 0], area[3])
    torch.testing.assert_close(operators[1], operators[0])
    assert (operators[2, 0] - area[4]).norm() > 0.01
    others = Bodies(40, seed=1, topology="notoes_collapse5pc")  # of the same names
    assert (operators_of(trained, choose(others, asked), made.pipeline, 5)[0, 0] - area[3]).norm() > 0.01


TESTED, OTHERS = {"body_0000", "body_0001"}, {"body_0002", "body_0003"}  # with task.bodies=2


def test_the_benchmark(program, vertices, tmp_path):
    arguments = ("task.quadruples=4", "task.validation=2", "task.bodies=2", "task.points=128")
    metrics = program(tmp_path, "task=analogy_benchmark", f"ckpt_path={vertices}", *BODIES, *arguments)
    for part in ("test", "validation"):
        assert metrics[f"{part}/own/over_own"] == 1
        for name in (*METHODS, "own", "C"):
            halves = [metrics[f"{part}/{name}/{role}/cd"] for role in ("pose", "body")]
            assert metrics[f"{part}/{name}/cd"] == pytest.approx(np.mean(halves))
    # In symmetric algebra B and C change places.
    assert metrics["test/log_euclidean/pose/cd"] == pytest.approx(metrics["test/log_euclidean/body/cd"], rel=1e-3)
    assert metrics["test/own/cd"] < metrics["test/C/cd"]
    best = min(METHODS, key=lambda method: metrics[f"validation/{method}/cd"])
    assert metrics["test/best/cd"] == metrics[f"test/{best}/cd"]
    with (tmp_path / "analogies.csv").open(encoding="utf-8") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == 2 * (4 + 2) * 6
    for line in lines:
        (p, a), (q, b) = line["A"].split(":"), line["truth"].split(":")
        assert {line["B"], line["C"]} == {f"{p}:{b}", f"{q}:{a}"}
        # Validation chooses the method, so its bodies are others than those of the test.
        assert {p, q} <= {"test": TESTED, "validation": OTHERS}[line["part"]]
        assert (line["B"] == f"{p}:{b}") == (line["role"] == "pose")


def test_the_benchmark_of_a_net_that_gives_clouds(program, cloud, tmp_path):
    arguments = ("task.quadruples=2", "task.validation=1", "task.bodies=2", "task.points=128")
    metrics = program(tmp_path, "task=analogy_benchmark", f"ckpt_path={cloud}", *BODIES, *arguments)
    assert "test/own/vertex_error_mm" not in metrics
    assert "test/C/vertex_error_mm" in metrics
    assert metrics["test/multiplicative/cd"] > 0


def test_a_path(program, vertices, tmp_path):
    arguments = ("task=interpolation", f"ckpt_path={vertices}", *BODIES, "task.a=body_0000", "task.steps=5")
    metrics = program(tmp_path, *arguments, "task.b=body_0008")
    for method in ("linear", "log_euclidean"):
        assert metrics[f"{method}/progress"] == 1
        assert len(list((tmp_path / method).glob("*.glb"))) == 5
        path = np.stack([load(tmp_path / method / f"{i:02d}.ply").vertices for i in range(5)])
        steps = 1000 * np.linalg.norm(np.diff(path, axis=0), axis=2).mean(1)
        assert metrics[f"{method}/step_ratio"] == pytest.approx(steps.max() / steps.min(), rel=1e-3)
        assert metrics[f"{method}/length_mm"] == pytest.approx(steps.sum(), rel=1e-4)
        assert metrics[f"{method}/length_mm"] >= 1000 * np.linalg.norm(path[-1] - path[0], axis=1).mean()
    for end in ("00", "04"):
        one, other = (load(tmp_path / method / f"{end}.ply").vertices for method in ("linear", "log_euclidean"))
        np.testing.assert_allclose(one, other, atol=1e-4)
    assert (tmp_path / "interpolation.png").read_bytes()[:4] == b"\x89PNG"


def test_smoothness_of_paths_by_hand():
    even = np.zeros((5, 3, 3))
    even[:, :, 0] = np.arange(5)[:, None]
    assert smoothness(even) == {"length_mm": 4000, "longest_mm": 1000, "step_ratio": 1, "progress": 1}
    back = even[[0, 2, 1, 4]]
    found = smoothness(back)
    assert (found["step_ratio"], found["length_mm"]) == (3, 6000)
    assert found["progress"] == pytest.approx(2 / 3)
    still = smoothness(np.zeros((3, 2, 3)))
    assert (still["progress"], still["step_ratio"]) == (0, 0)


def test_quadruples_are_two_bodies_in_two_poses():
    found = draw_quadruples(range(3, 6), 50, np.random.default_rng(0))
    assert len(set(found)) == len(found) == 100
    n = len(POSE_NAMES)
    for q in found:
        (p, a), (r, b) = divmod(q.A, n), divmod(q.truth, n)
        assert {p, r} <= {3, 4, 5}
        assert p != r
        assert a != b
        assert ((p * n + b, r * n + a) if q.role == "pose" else (r * n + a, p * n + b)) == (q.B, q.C)
    with pytest.raises(InputError, match="quadruples=113: 2 bodies give 112 at most"):
        draw_quadruples(range(2), 113, np.random.default_rng(0))


def test_regions_by_part_file_and_number(tmp_path):
    bodies = Bodies(8, topology="notoes_collapse5pc")
    mask = bodies.parts["left_arm"]
    np.save(tmp_path / "mask.npy", mask)
    np.save(tmp_path / "numbers.npy", np.flatnonzero(mask))
    np.savetxt(tmp_path / "numbers.txt", np.flatnonzero(mask), "%d")
    np.savetxt(tmp_path / "mask.txt", mask, "%d")
    given = ["left_arm", np.flatnonzero(mask).tolist(), *map(str, tmp_path.iterdir())]
    assert len(given) == 6
    for region in given:
        assert np.array_equal(region_mask(region, bodies, 615), mask)


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ("tail", "task.region=tail: expected a .npy or .txt file, a list of vertices, or one of: head"),
        ("tail.npy", "task.region=tail.npy: no such file"),
        ([615], r"task.region=\[1 numbers\]: expected numbers of vertices, 0 to 614"),
        ([0.5], "expected numbers of vertices"),
        ([], "expected some of 615 vertices, got 0 of 615"),
        (list(range(615)), "expected some of 615 vertices, got 615 of 615"),
    ],
)
def test_regions_that_are_none(region, message):
    with pytest.raises(InputError, match=message):
        region_mask(region, Bodies(8, topology="notoes_collapse5pc"), 615)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("task=interpolation", "task.a=body_0000", "task.b=body_0099"), "task.b=body_0099: expected the name of a sh"),
        (("task=interpolation", "task.a=body_0000:flying", "task.b=body_0000"), "pose: expected one of rest"),
        (("task=interpolation", "task.a=body_0000", "task.b=body_0001", "task.steps=2"), "task.steps=2"),
        (("task=analogy_benchmark", "task.seed=0"), "task.seed=0: expected another than collection.seed"),
        (("task=analogy_benchmark", "task.bodies=1"), "task.bodies=1"),
    ],
)
def test_mistakes_are_told(program, vertices, tmp_path, overrides, message):
    with pytest.raises(InputError, match=message):
        program(tmp_path, *BODIES, f"ckpt_path={vertices}", *overrides)


def test_checkpoints_of_something_else_are_refused(program, tmp_path):
    names = ("task=interpolation", "task.a=body_0000", "task.b=body_0001", *BODIES)
    with pytest.raises(InputError, match="task=interpolation: expected ckpt_path=…"):
        program(tmp_path, *names)
    program(tmp_path / "r", *BODIES, *SMALL[3:-1], "task.epochs=1")
    checkpoint = tmp_path / "r" / "best.ckpt"
    with pytest.raises(
        InputError, match="expected the best.ckpt of task=reconstruction, but it does not name its faces"
    ):
        program(tmp_path, *names, f"ckpt_path={checkpoint}")
    program(tmp_path / "a", *SMALL, "net=autoencoder", "task.epochs=1", "data.points=64")
    with pytest.raises(InputError, match="expected a net that reads operators, this one reads clouds"):
        program(tmp_path, *names, f"ckpt_path={tmp_path / 'a' / 'best.ckpt'}")
