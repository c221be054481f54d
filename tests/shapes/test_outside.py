"""What of a mesh is seen from outside."""

import numpy as np
import trimesh

from lssd_learn.shapes.mending.outside import AXES, _half_sphere, seen_from_outside


def shell(inner=0.8, subdivisions=2):
    """A sphere in a sphere."""
    ball = trimesh.creation.icosphere(subdivisions)
    n, faces = len(ball.vertices), np.array(ball.faces)
    return np.concatenate([ball.vertices, inner * ball.vertices]), np.concatenate([faces, faces[:, ::-1] + n])


def test_half_of_all_directions_on_a_sphere_and_none_in_it():
    vertices, faces = shell()
    seen = seen_from_outside(vertices, faces)
    np.testing.assert_allclose(seen[: len(faces) // 2], 0.5)
    assert (seen[len(faces) // 2 :] == 0).all()


def test_turned_faces_and_other_units_change_nothing():
    vertices, faces = shell()
    bent = vertices * [1, 1.5, 2] + 0.3 * np.sin(3 * vertices[:, [1, 2, 0]])
    seen = seen_from_outside(bent, faces)
    np.testing.assert_array_equal(seen_from_outside(bent, faces[:, ::-1]), seen)
    np.testing.assert_array_equal(seen_from_outside(1024 * bent, faces), seen)


def test_as_one_ray_after_another_says():
    vertices, faces = shell(0.7, subdivisions=1)
    vertices = vertices + np.random.default_rng(0).normal(0, 0.08, vertices.shape)
    faces = np.delete(faces, [3, 40, 61], axis=0)  # windows
    a, b, c = vertices[faces].swapaxes(0, 1)
    count = np.zeros(len(faces))
    for axis in _half_sphere(AXES):
        for direction in (axis, -axis):
            for f, start in enumerate((a + b + c) / 3):
                # start + r · direction = a + s (b − a) + t (c − a), of each face (Cramer)
                columns = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=2)
                s, t, r = np.linalg.solve(columns, (start - a)[:, :, None])[:, :, 0].T
                hit = (s >= 0) & (t >= 0) & (s + t <= 1) & (r > 0)
                hit[f] = False
                count[f] += not hit.any()
    np.testing.assert_allclose(seen_from_outside(vertices, faces), count / (2 * AXES))
