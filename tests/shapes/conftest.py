import numpy as np
import pytest
import trimesh

from lssd_learn.shapes import Mesh


def bumpy_sphere(subdivisions):
    """A closed mesh without any symmetry."""
    sphere = trimesh.creation.icosphere(subdivisions)
    x, y, z = np.array(sphere.vertices).T
    radius = 1 + 0.2 * np.sin(2 * x + 1) * np.cos(3 * y + 0.5) + 0.15 * z * x + 0.1 * z
    return Mesh((radius * [x, 1.3 * y, 0.8 * z]).T, sphere.faces)


@pytest.fixture(scope="session")
def small_mesh():
    """642 vertices, closed, smooth, asymmetric."""
    return bumpy_sphere(3)


@pytest.fixture(scope="session")
def sphere():
    """2,562 vertices of the unit sphere."""
    mesh = trimesh.creation.icosphere(4)
    return Mesh(mesh.vertices, mesh.faces)


@pytest.fixture(scope="session")
def square():
    """A function n → the unit square of n × n cells, each cut into two triangles."""

    def make(n):
        x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
        a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
        b, c, d = a + 1, a + n + 1, a + n + 2
        faces = np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])
        return Mesh(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1), faces)

    return make
