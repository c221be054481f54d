"""Public benchmarks in the three layouts they come in, written here from generated shapes whose truth is known."""

import numpy as np
import pytest
from scipy.io import savemat

from lssd_learn.collections import Benchmark, Bodies
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, save

NAMES = ("tr_reg_000", "tr_reg_001", "tr_reg_002")


@pytest.fixture(scope="module")
def scans():
    """Bodies of one template, the vertices of each in an order of its own, and for each vertex that of the template."""
    rng = np.random.default_rng(0)
    made = []
    for mesh in Bodies(n=3, topology="notoes_collapse3pc"):
        order = rng.permutation(len(mesh.vertices))
        made.append((Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces]), order))
    return made


def numbers(values):
    return "\n".join(str(v + 1) for v in values) + "\n"


def leave(scans, path, names=NAMES):
    (path / "off").mkdir(parents=True)
    (path / "corres").mkdir()
    for name, (mesh, _) in zip(names, scans, strict=True):
        save(mesh, path / "off" / f"{name}.off")
    return path


@pytest.fixture
def templated(scans, tmp_path):
    path = leave(scans, tmp_path / "FAUST_r")
    for name, (_, order) in zip(NAMES, scans, strict=True):
        (path / "corres" / f"{name}.vts").write_text(numbers(np.argsort(order)))
    return path


def same_points(collection, scans, i, j):
    """Whether known points of two shapes come from one vertex of the template; how many there are."""
    here, there = collection.known(i, j)
    np.testing.assert_array_equal(scans[i][1][here], scans[j][1][there])
    return len(here)


def test_a_file_a_shape_tells_where_the_template_is(templated, scans):
    found = Benchmark(templated)
    assert found.names == list(NAMES)
    assert len(found.pairs) == len(found.vertex_maps) == 6
    assert same_points(found, scans, 2, 0) == len(scans[0][1])
    np.testing.assert_array_equal(scans[1][1][found.vertex_maps[1, 2]], scans[2][1])
    assert found.truth
    assert {mesh.connectivity for mesh in found} == {None}
    assert list(found.check()) == []


def test_only_some_of_the_shapes(templated, scans):
    found = Benchmark(templated, first=1, last=3)
    assert found.names == list(NAMES[1:])
    assert found.pairs == [(0, 1), (1, 0)]
    here, there = found.known(0, 1)
    np.testing.assert_array_equal(scans[1][1][here], scans[2][1][there])
    for first, last in ((3, None), (1, 1), (0, 4)):
        with pytest.raises(InputError, match="collection.(first|last)="):
            Benchmark(templated, first=first, last=last)


def test_turned_shapes_keep_their_truth_and_have_keys_of_their_own(templated):
    plain, turned = Benchmark(templated), Benchmark(templated, turned="any", seed=3)
    turn = np.linalg.lstsq(plain[1].vertices, turned[1].vertices)[0]
    np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-9)
    assert not np.allclose(turn, np.eye(3), atol=0.1)
    assert turned[1].connectivity is None
    np.testing.assert_array_equal(plain.vertex_maps[0, 1], turned.vertex_maps[0, 1])
    assert len({plain.shape_key(1), turned.shape_key(1), Benchmark(templated, turned="any").shape_key(1)}) == 3
    with pytest.raises(InputError, match="collection.turned=about: expected one of none, vertical, any"):
        Benchmark(templated, turned="about")


def test_all_but_one_lead_to_a_reference(scans, tmp_path):
    names = ("kid00", "kid01", "kid02")
    path = leave(scans, tmp_path / "TOPKIDS", names)
    for name, (_, order) in list(zip(names, scans, strict=True))[1:]:
        to_reference = np.argsort(scans[0][1])[order]
        (path / "corres" / f"{name}_ref.txt").write_text(numbers(to_reference))
    found = Benchmark(path)
    assert found.pairs == [(0, 1), (0, 2)]
    assert same_points(found, scans, 0, 2) == len(scans[2][1])
    with pytest.raises(KeyError):
        found.vertex_maps[2, 0]


def test_a_file_a_pair(scans, tmp_path):
    path = leave(scans, tmp_path / "SHREC19_r", ("1", "2", "10"))
    to = np.argsort(scans[1][1])[scans[2][1]]  # in the order of their names 1, 10, 2: from the second to the third
    (path / "corres" / "10_2.map").write_text(numbers(to))
    savemat(path / "corres" / "1_10.mat", {"map": np.argsort(scans[2][1])[scans[0][1]] + 1.0})
    found = Benchmark(path)
    assert found.names == ["1", "10", "2"]
    assert sorted(found.pairs) == [(0, 1), (1, 2)]
    assert same_points(found, [scans[0], scans[2], scans[1]], 1, 2) == len(to)
    assert same_points(found, [scans[0], scans[2], scans[1]], 0, 1) == len(to)


def test_what_does_not_fit_is_told(templated, tmp_path):
    (templated / "corres" / "tr_reg_001.vts").write_text("1\n2\n3\n")
    with pytest.raises(InputError, match=r"tr_reg_001.vts: expected 369 vertices, one for each of the template as in"):
        Benchmark(templated).check()
    (templated / "corres" / "tr_reg_001.vts").write_text("0\n2\n3\n")
    with pytest.raises(InputError, match=r"tr_reg_001.vts: expected vertices counted from 1, up to 369, got 0 to 3"):
        Benchmark(templated).known(1, 2)
    savemat(templated / "corres" / "tr_reg_001.mat", {"a": np.arange(3), "b": np.arange(3)})
    with pytest.raises(InputError, match="expected one file a shape or pair, got tr_reg_001.mat and tr_reg_001.vts"):
        Benchmark(templated)
    (templated / "corres" / "tr_reg_001.vts").unlink()
    with pytest.raises(InputError, match=r"tr_reg_001.mat: expected one vector of vertices, got a, b"):
        Benchmark(templated).known(0, 1)
    for file in (templated / "corres").iterdir():
        file.unlink()
    with pytest.raises(InputError, match="expected correspondences.* there is none of tr_reg_000, tr_reg_001"):
        Benchmark(templated)
    with pytest.raises(InputError, match="expected a folder of shapes, it is not there"):
        Benchmark(tmp_path / "nowhere")


def test_the_key_depends_on_the_correspondences(templated, scans):
    before = Benchmark(templated).key
    (templated / "corres" / "tr_reg_001.vts").write_text(numbers(np.argsort(scans[1][1])[::-1]))
    after = Benchmark(templated)
    assert after.key != before
    assert after.shape_key(1) == Benchmark(templated).shape_key(1)
