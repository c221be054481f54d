import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.shapes import Mesh
from lssd_learn.shapes.reading.polygons import ears, triangles

L = np.array([[2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0], [0, 0, 0]], dtype=float)


def cut(points, *polygons):
    return triangles(points, np.concatenate(polygons), np.array([len(polygon) for polygon in polygons]))


def area(polygon: np.ndarray) -> float:
    """Of a flat polygon."""
    return float(np.linalg.norm(np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0)) / 2)


@pytest.mark.parametrize("turn", range(6))
@pytest.mark.parametrize("backwards", [False, True])
def test_an_l_has_its_area_wherever_it_begins(turn, backwards):
    order = np.roll(np.arange(6), turn)[:: -1 if backwards else 1]
    faces, notes = cut(L, order)
    assert notes == ()
    assert len(faces) == 4
    np.testing.assert_allclose(Mesh(L, faces).area, 3)
    up = np.cross(L[faces[:, 1]] - L[faces[:, 0]], L[faces[:, 2]] - L[faces[:, 0]])[:, 2]
    assert (up < 0).all() if backwards else (up > 0).all()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(5, 30), lean=st.booleans())
def test_stars_of_any_form_keep_area_winding_and_every_corner(seed, n, lean):
    """Radii of any size at ascending angles: concave, and simple."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(n) + rng.uniform(0, 0.9, n)) / n
    flat = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * rng.uniform(0.1, 1, (n, 1))
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0] if lean else np.eye(3)
    points = flat @ turn.T + 5
    faces, _ = cut(points, np.roll(np.arange(n), rng.integers(n)))
    assert set(faces.ravel()) == set(range(n))
    np.testing.assert_allclose(Mesh(points, faces).area, area(points - 5), rtol=1e-9)
    # One loop of border, and every inner edge both ways.
    sides = {(a, b) for face in faces.tolist() for a, b in zip(face, np.roll(face, -1).tolist(), strict=True)}
    assert len(sides) == 3 * (n - 2)
    assert {(a, b) for a, b in sides if (b, a) not in sides} == {(i, (i + 1) % n) for i in range(n)}


def test_corners_in_line_stay():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0], [0, 2, 0]], dtype=float)
    for turn in range(6):
        faces, _ = cut(points, np.roll(np.arange(6), turn))
        mesh = Mesh(points, faces)
        np.testing.assert_allclose(mesh.area, 4)
        assert mesh.face_areas.min() > 0
        assert set(faces.ravel()) == set(range(6))


def test_a_hole_joined_to_the_rim_stays_a_hole():
    rim = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], dtype=float)
    hole = np.array([[1, 1, 0], [1, 3, 0], [3, 3, 0], [3, 1, 0]], dtype=float)
    points = np.vstack([rim, hole])
    faces, _ = cut(points, np.array([0, 1, 2, 3, 0, 4, 5, 6, 7, 4]))
    np.testing.assert_allclose(Mesh(points, faces).area, 12)


def test_a_concave_quad_is_cut_at_its_dent():
    points = np.array([[0, 0, 0], [2, -1, 0], [0.5, 0, 0], [2, 1, 0]])[:, [0, 1, 2]]
    for turn in range(4):
        faces, _ = cut(points, np.roll(np.arange(4), turn))
        np.testing.assert_allclose(Mesh(points, faces).area, 0.5)


def test_quads_that_bend_are_fans_and_stay_in_order():
    points = np.array([[0, 0, 0], [1, 0, 0.2], [1, 1, 0], [0, 1, 0.3], [2, 0, 0], [2, 1, 0]])
    faces, _ = cut(points, np.array([1, 4, 2]), np.array([0, 1, 2, 3]), np.array([4, 5, 2]))
    assert faces.tolist() == [[1, 4, 2], [0, 1, 2], [0, 2, 3], [4, 5, 2]]


def test_what_has_no_three_corners_is_left_out():
    faces, notes = cut(L, np.array([0, 1]), np.array([0, 1, 1, 2]), np.array([3, 3, 4, 4]), np.array([5]))
    assert faces.tolist() == [[0, 1, 2]]
    assert notes == ("left out 3 faces of fewer than three corners",)


@pytest.mark.parametrize("polygon", [[0, 2, 1, 3], [0, 2, 4, 1, 3]])
def test_faces_that_cross_themselves_are_refused(polygon):
    around = 2 * np.pi * np.arange(len(polygon)) / len(polygon)
    points = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
    with pytest.raises(ValueError, match="a face crosses itself"):
        cut(points, np.array(polygon))


def test_a_thousand_corners():
    around = 2 * np.pi * np.arange(1000) / 1000
    points = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1) * (1 + 0.3 * np.cos(9 * around))[:, None]
    np.testing.assert_allclose(Mesh(points, ears(points)).area, area(points), rtol=1e-12)
