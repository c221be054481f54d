"""Shapes with the same faces whose vertices do not correspond."""

import numpy as np

from lssd_learn.collections import Bodies, Faces, Folder
from lssd_learn.collections.reading.alike import SameFaces
from lssd_learn.collections.reading.told import Told
from lssd_learn.shapes import Mesh, save


def warnings_of(meshes):
    told = Told()
    same = SameFaces([f"s{i}" for i in range(len(meshes))], told)
    for i, mesh in enumerate(meshes):
        same.add(i, mesh)
    same.tell()
    return told.warnings


def test_people_in_all_poses_and_faces_of_all_kinds_are_silent():
    assert warnings_of(list(Bodies(n=16, topology="notoes_collapse5pc", seed=2))) == []
    assert warnings_of(list(Faces(identities=2))) == []


def test_bent_spheres_are_silent(deformed_spheres):
    assert warnings_of(deformed_spheres(20, 2, seed=3)) == []


def test_permuted_vertices_are_named(folder, lumps):
    mesh = lumps(5)[0]
    order = np.random.default_rng(0).permutation(162)
    save(Mesh(mesh.vertices[order], mesh.faces), folder / "s0.off")
    (warning,) = Folder(folder).check()
    assert warning.startswith("s0: the same faces as s1, but edges that are not alike")
    assert Folder(folder, correspondence="none").check() == []


def test_scale_and_another_place_are_no_matter(lumps):
    a, b = lumps(2)
    assert warnings_of([a, Mesh(1000 * b.vertices + [5, 5, 5], b.faces)]) == []
    assert len(warnings_of([a, Mesh(np.roll(b.vertices, 1, axis=0), b.faces)])) == 1
