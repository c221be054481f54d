"""A new body among bodies in correspondence: its points are found to less than the distance between two vertices."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.maps.span.fit import Surface, fitted
from lssd_learn.maps.span.net import net
from lssd_learn.maps.span.span import laid_on, nearest_to, posed_off, span
from lssd_learn.maps.span.spanned import LEAST, POSED, Alike, spanned
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.normals import normals

TURN = Rotation.from_euler("xyz", [0.3, 1.2, -2.0]).as_matrix()


@pytest.fixture(scope="module")
def known():
    """Thirty people with their arms down."""
    bodies = Bodies(n=30, topology="notoes_collapse5pc")
    return ShapeList([bodies.make(values, "arms_down") for values in bodies.parameters])


@pytest.fixture(scope="module")
def new():
    """Another one, turned."""
    bodies = Bodies(n=1, seed=7, topology="notoes_collapse5pc")
    body = bodies.make(bodies.parameters[0], "arms_down")
    return Mesh(body.vertices @ TURN + [3, 1, 2], body.faces)


@pytest.fixture(scope="module")
def slid(new):
    """About where its vertices lie: off by some centimetres, neighbouring ones alike, as maps are."""
    off = np.random.default_rng(0).normal(size=new.vertices.shape) * 0.1
    near = np.argsort(np.linalg.norm(new.vertices[:, None] - new.vertices, axis=2))[:, :20]
    return new.vertices + off[near].mean(axis=1)


def test_shapes_are_laid_on_goals_and_the_nearest_is_found(known, new):
    shapes, mass = np.stack([shape.vertices for shape in known]), np.full(len(new.vertices), 1 / len(new.vertices))
    goals = shapes[4] @ TURN + 5
    lying, off = laid_on(shapes, goals, mass)
    np.testing.assert_allclose(lying[4], goals - goals.mean(axis=0), atol=1e-9)
    assert off[4] == pytest.approx(0, abs=1e-9)
    assert nearest_to(shapes, goals, mass, 3)[0] == 4


def test_a_span_holds_its_shapes(known):
    shapes, mass = np.stack([shape.vertices for shape in known][:6]), np.full(len(known[0].vertices), 2.0)
    of = span(shapes, shapes[0], mass)
    assert len(of.deviations) == 5
    gram = np.einsum("rvx,v,svx->rs", of.modes, of.mass, of.modes)
    np.testing.assert_allclose(gram, np.eye(5), atol=1e-9)
    lying = laid_on(shapes, shapes[0], of.mass)[0]
    weights = np.einsum("rvx,v,nvx->nr", of.modes, of.mass, lying - of.mean)
    np.testing.assert_allclose(of.at(weights[3]), lying[3], atol=1e-3)


def test_points_that_slid_come_back(known, new, slid):
    size = np.sqrt(new.area)
    shapes, mass = np.stack([shape.vertices for shape in known]), np.full(len(slid), 1 / len(slid))
    of = span(shapes / size, slid / size, mass)
    before = np.linalg.norm(slid - new.vertices, axis=1).mean() / size
    for facing, left in ((normals(new), 0.1), (None, 0.25)):  # of a mesh, of a cloud
        points = fitted(of, known[0], slid / size, Surface(new.vertices / size, facing))
        assert np.linalg.norm(points - new.vertices / size, axis=1).mean() < left * before


def test_a_mixture_fits_and_says_where_points_are_and_a_shape_that_is_none_does_not(known, new, slid):
    alike, mass = Alike(known, range(len(known))), np.full(len(slid), 1 / len(slid))
    found = spanned(alike, mass, slid, new)
    assert found is not None
    assert found.fits
    before = np.linalg.norm(slid - new.vertices, axis=1).mean()
    assert np.linalg.norm(found.points - new.vertices, axis=1).mean() < 0.1 * before
    bent = Bodies(n=1, seed=7, topology="notoes_collapse5pc").make([0.5] * 12, "stride")
    other = spanned(alike, mass, bent.vertices, bent, bend=False)
    assert other is not None
    assert not other.fits
    assert spanned(Alike(known, range(LEAST)), mass, slid, new, own=3) is None


def test_the_own_shape_is_no_part_of_it(known):
    alike, mass = Alike(known, range(len(known))), np.full(615, 1 / 615)
    found = spanned(alike, mass, known[3].vertices, known[3], own=3)
    assert found is not None
    assert 3 not in found.shapes


def test_a_cloud_is_a_mixture_too(known, new, slid):
    alike, mass = Alike(known, range(len(known))), np.full(len(slid), 1 / len(slid))
    found = spanned(alike, mass, slid, PointCloud(new.vertices))
    assert found is not None
    assert found.fits
    off = np.linalg.norm(found.points - new.vertices, axis=1).mean()
    assert off < 0.25 * np.linalg.norm(slid - new.vertices, axis=1).mean()


def test_a_net_holds_a_mesh_of_several_pieces(known):
    body = known[0]
    far = Mesh(
        np.vstack([body.vertices, [[9, 0, 0], [9, 0.01, 0], [9, 0, 0.01]]]), np.vstack([body.faces, [[615, 616, 617]]])
    )
    on = net(far)
    np.testing.assert_allclose(on.shares.sum(axis=1), 1)
    assert (on.shares >= 0).all()
    assert (on.followed[np.arange(618), 0][on.knots] == np.arange(len(on.knots))).all()
    assert set(zip(on.i.tolist(), on.j.tolist(), strict=True)) == set(zip(on.j.tolist(), on.i.tolist(), strict=True))


def test_shapes_that_stand_alike_are_found_whatever_their_build():
    bodies = Bodies(n=16, topology="notoes_collapse5pc")
    shapes = np.stack([bodies[i].vertices for i in range(16)])
    for i in (0, 3, 6):
        assert np.flatnonzero(posed_off(shapes, shapes[i] @ TURN) < POSED).tolist() == [i, i + 8]


def test_who_stands_as_nobody_does_is_a_mixture_once_bent(known):
    bodies = Bodies(n=1, seed=7, topology="notoes_collapse5pc")
    straight = bodies.make(bodies.parameters[0], "arms_down")
    angles = {
        "upperarm01.L": (12, 30, 9),
        "upperarm01.R": (-8, -40, 12),
        "upperleg01.L": (-14, 5, 5),
        "spine03": (9, -6, 12),
    }
    other = bodies.make(bodies.parameters[0], angles)
    other = Mesh(other.vertices @ TURN + 2, other.faces)
    alike, mass = Alike(known, range(len(known))), np.full(615, 1 / 615)
    found = spanned(alike, mass, other.vertices, other)
    assert found is not None
    assert found.bent
    assert found.fits

    def away(points):
        return laid_on(points[None], straight.vertices, mass)[1][0]

    assert away(found.points) < 0.3 * min(away(shape.vertices) for shape in known)
    assert not spanned(alike, mass, other.vertices, other, bend=False).fits
