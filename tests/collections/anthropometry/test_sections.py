import numpy as np
import pytest
import trimesh

from lssd_learn.collections.anthropometry.sections import loop_length, section, tape
from lssd_learn.shapes.edges import edges

ACROSS = np.array([0.3, -0.5, 1.0])


def test_a_section_lies_in_its_plane_and_the_tape_around_a_sphere_is_a_circle():
    ball = trimesh.creation.icosphere(5, radius=2.0)
    points = section(np.array(ball.vertices), edges(np.array(ball.faces)), np.full(3, 0.4), ACROSS)
    away = (0.4 * ACROSS.sum()) / np.linalg.norm(ACROSS)
    assert np.abs((points - 0.4) @ ACROSS).max() < 1e-12
    assert tape(points, ACROSS)[0] == pytest.approx(2 * np.pi * np.sqrt(4 - away**2), rel=1e-3)


def test_a_tape_spans_hollows_and_lies_on_points_of_the_body():
    star = np.array([[2.0, 0, 5], [0.3, 0.3, 5], [0, 2, 5], [-0.3, 0.3, 5], [-2, 0, 5], [0, -2, 5]])
    length, points = tape(star, np.array([0, 0, 3.0]))
    assert length == pytest.approx(4 * np.sqrt(8))
    assert {tuple(p) for p in points} == {tuple(p) for p in star[[0, 2, 4, 5]]}


def test_a_loop_is_closed():
    assert loop_length(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])) == pytest.approx(4)
