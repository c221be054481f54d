"""Small lopsided shapes, no side of which is like another: what tables and maps are judged by."""

import numpy as np
import pytest
import trimesh

from lssd_learn.shapes import Mesh, save


@pytest.fixture(scope="session")
def lumps():
    """A function n → n shapes of 162 vertices and the same faces, alike and each a little different."""

    def make(n, subdivisions=2):
        sphere = trimesh.creation.icosphere(subdivisions)
        x = np.array(sphere.vertices)
        bump = np.exp(-4 * ((x - [0.6, 0.64, 0.48]) ** 2).sum(1)) - 0.5 * np.exp(
            -4 * ((x - [-0.8, 0.0, 0.6]) ** 2).sum(1)
        )
        wide = x * [1.0, 1.4, 2.0] * (1 + 0.8 * bump[:, None])
        sizes = 1 + 0.1 * np.random.default_rng(0).random((n, 3))
        return [Mesh(wide * size, sphere.faces) for size in sizes]

    return make


@pytest.fixture
def folder(lumps, tmp_path):
    """Five of them as s0.off to s4.off."""
    for i, mesh in enumerate(lumps(5)):
        save(mesh, tmp_path / f"s{i}.off")
    return tmp_path
