"""`task=place_agreement` through the configuration, and the walled shapes that it is asked about."""

import csv

import numpy as np
import pytest
from hydra.errors import InstantiationException

from lssd_learn.collections import Faces, Remeshed, Walled
from lssd_learn.errors import InputError
from lssd_learn.measures.place_agreement import smoothed

SMALL = ("task=place_agreement", "basis.k=30", "latent.size=28", "latent.keep=24", "parallel.workers=1")
BODIES = ("collection=changed", "collection.topology=notoes_collapse5pc", "task.group=size")
HEADS = ("collection=walled", "collection.base.base.identities=2", "collection.base.vertices=[700,900]", "maps=spline")


@pytest.fixture(scope="module")
def heads():
    base = Remeshed(Faces(identities=1, expressions=["neutral", "surprised"]), vertices=(700, 900), marks=6)
    return {mask: Walled(base, mask=mask) for mask in (None, "outer")}


def test_operators_say_where_bodies_with_known_vertices_differ(runs_of, tmp_path):
    found = runs_of(*SMALL)(*BODIES, "collection.n=4")
    assert found["truth/operators/smoothed"] > 0.97
    assert found["truth/operators/smoothed"] > found["truth/landmarks/smoothed"] > 0.5
    assert found["landmarks"] > 0.5
    assert found["landmarks/count"] == 51
    with (tmp_path / "places.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 8
    assert (tmp_path / "places.png").is_file()


@pytest.mark.slow
def test_of_walled_heads_the_truth_is_asked_on_the_outer_wall(runs_of):
    found = runs_of(*SMALL)(*HEADS, "collection.mask=outer", "task.group=expression")
    assert found["shapes"] == 4
    assert found["truth/operators/smoothed"] > 0.2  # of four small heads


def test_a_wall_stands_inside_and_the_mask_takes_it(heads):
    whole, outer = (heads[mask] for mask in (None, "outer"))
    base = whole.base[0]
    there = whole.origins(0) >= 0
    assert there.mean() == pytest.approx(0.5, abs=0.01)
    np.testing.assert_array_equal(whole[0].vertices[there], base.vertices[whole.origins(0)[there]])
    middle = base.vertices.mean(0)
    sizes = [np.linalg.norm(whole[0].vertices[some] - middle, axis=1).mean() for some in (there, ~there)]
    assert sizes[1] / sizes[0] == pytest.approx(0.88, abs=0.01)
    assert (outer.origins(0) >= 0).mean() > 0.8
    assert outer[0].area == pytest.approx(base.area, rel=0.2)
    assert whole[0].connectivity != whole[1].connectivity
    marks = outer.landmarks[0]
    assert set(marks) == set(whole.base.landmarks[0])
    assert outer.shape_key(0) != whole.shape_key(0)


def test_what_is_smoothed_is_what_an_operator_tells(pieces_of, tmp_path):
    """Of the same field everywhere, itself; and a field between its least and its largest value."""
    latent = pieces_of(tmp_path, *SMALL, *BODIES, "collection.n=2").pipeline.latent
    V = len(latent.eigenbasis(0).mass)
    np.testing.assert_allclose(smoothed(latent, np.full(V, 0.3), 0), 0.3, atol=1e-9)
    field = np.linspace(-1, 1, V)
    assert np.abs(smoothed(latent, field, 0)).max() < 1


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ((*BODIES[:2], "collection.n=3", "task.group=pose"), "expected two groups, got 3"),
        (
            (
                "collection=remeshed_faces",
                "collection.base.identities=2",
                "collection.vertices=[700,900]",
                "task.group=expression",
            ),
            "expected landmarks, or shapes whose vertices correspond",
        ),  # fmt: skip
        ((*HEADS, "collection.mask=inner"), "expected outer or null"),
    ],
)
def test_mistakes(runs_of, overrides, message):
    with pytest.raises((InputError, InstantiationException), match=message):
        runs_of(*SMALL)(*overrides)
