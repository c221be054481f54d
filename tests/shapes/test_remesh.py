import numpy as np
import pytest
import trimesh

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, eigenbasis
from lssd_learn.shapes.remesh import remesh


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


@pytest.fixture(scope="module")
def body():
    return Bodies(n=1, topology="notoes_collapse10pc")[0]


def test_a_body_stays_closed_in_one_piece_and_nearly_as_large(body):
    made = remesh(body, 700, np.random.default_rng(0))
    solid = as_trimesh(made.mesh)
    assert len(made.mesh.vertices) == 700
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.euler_number == as_trimesh(body).euler_number == 2
    assert made.mesh.area == pytest.approx(body.area, rel=0.05)
    assert solid.volume == pytest.approx(as_trimesh(body).volume, rel=0.1)


def test_every_vertex_knows_where_it_comes_from(body):
    made = remesh(body, 600, np.random.default_rng(1))
    assert len(np.unique(made.origins)) == 600
    away = np.linalg.norm(made.mesh.vertices - body.vertices[made.origins], axis=1)
    corners = body.vertices[body.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    assert 0 < away.max() <= 0.45 * longest
    assert (away > 0).mean() > 0.5  # no two such meshes have their vertices in common


def test_spectra_agree_the_better_the_finer():
    sphere = trimesh.creation.icosphere(4)
    errors = []
    for count in (500, 2000):
        evals = eigenbasis(remesh(Mesh(sphere.vertices, sphere.faces), count, np.random.default_rng(0)).mesh, 9).evals
        errors.append(np.abs(evals[1:] / np.repeat([2, 6], [3, 5]) - 1).max())
    assert errors[1] < 0.03
    assert errors[1] < 0.5 * errors[0]


def test_borders_stay(body):
    opened = Mesh(body.vertices, body.faces[body.vertices[body.faces, 2].min(axis=1) > 0.3])
    border = trimesh.grouping.group_rows(np.sort(as_trimesh(opened).edges, axis=1), require_count=1)
    ends = np.unique(as_trimesh(opened).edges[border])
    made = remesh(opened, 400, np.random.default_rng(0))
    assert set(ends) <= set(made.origins.tolist())


def test_a_seed_is_a_mesh_and_no_collapse_is_the_mesh_in_another_order(body):
    first, again, other = (remesh(body, 700, np.random.default_rng(seed)) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first.mesh.vertices, again.mesh.vertices)
    assert first.mesh.connectivity == again.mesh.connectivity != other.mesh.connectivity
    same = remesh(body, len(body.vertices), np.random.default_rng(0))
    assert sorted(same.origins) == list(range(len(body.vertices)))
    assert len(same.mesh.faces) == len(body.faces)


def test_where_nothing_collapses_any_more_there_are_more_vertices(body):
    tetrahedron = trimesh.creation.icosphere(1)
    made = remesh(Mesh(tetrahedron.vertices, tetrahedron.faces), 4, np.random.default_rng(0))
    assert 4 <= len(made.mesh.vertices) < 42
    with pytest.raises(InputError, match="vertices=3: expected a whole number, 4 to 1,229"):
        remesh(body, 3, np.random.default_rng(0))
