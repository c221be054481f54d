"""Two shapes to map: a body and its copy with vertices and faces in another order, and bodies of two connectivities."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lssd_learn.collections import Bodies
from lssd_learn.shapes import Mesh, eigenbasis
from lssd_learn.shapes.sampling import farthest_points


@pytest.fixture(scope="session")
def shuffled():
    """A function mesh → (its copy with vertices and faces in another order, for each vertex of it that of the mesh)."""

    def make(mesh, seed=0):
        rng = np.random.default_rng(seed)
        order = rng.permutation(len(mesh.vertices))
        return Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces][rng.permutation(len(mesh.faces))]), order

    return make


@pytest.fixture(scope="session")
def twins(shuffled):
    """A body of 615 vertices (source) and its shuffled copy (target): an exact oracle for every method."""
    mesh = Bodies(n=1, topology="notoes_collapse5pc")[0]
    copy, true = shuffled(mesh)
    marks = farthest_points(copy.vertices, 8)
    return SimpleNamespace(
        source_shape=mesh, target_shape=copy, source=eigenbasis(mesh, 50), target=eigenbasis(copy, 50), true=true,
        side=Bodies(n=1, topology="notoes_collapse5pc").make({}).vertices[:, 0],
        source_landmarks=true[marks], target_landmarks=marks,
    )  # fmt: skip


@pytest.fixture(scope="session")
def bodies():
    """A body of 1,229 vertices (source) and another in its pose of 615; their truth is the nearest vertex at rest."""
    fine, coarse = (Bodies(n=11, topology=f"notoes_collapse{name}pc") for name in (10, 5))
    at_rest = fine.make({})
    true = cKDTree(at_rest.vertices).query(coarse.make({}).vertices)[1]
    source, target = fine[2], coarse[10]
    marks = farthest_points(coarse.make({}).vertices, 8)
    return SimpleNamespace(
        source_shape=source, target_shape=target, source=eigenbasis(source, 60), target=eigenbasis(target, 60),
        true=true, side=at_rest.vertices[:, 0], source_landmarks=true[marks], target_landmarks=marks,
    )  # fmt: skip
