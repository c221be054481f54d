import numpy as np
import pytest
import torch

from lssd_learn.cache import Cache
from lssd_learn.collections import Bodies, Remeshed
from lssd_learn.collections.anthropometry.measures import MEASURES, NAMES, TOPOLOGY
from lssd_learn.collections.columns import enclosed_volume
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.collections.generated.measured import measured, taped
from lssd_learn.errors import InputError

SMALL = "notoes_collapse5pc"
MIDDLE = {"muscle": 0.5, "weight": 0.5, "height": 0.5}


def at(name):
    return NAMES.index(name)


@pytest.fixture(scope="module")
def middle():
    return measured([MIDDLE])[0]


def test_what_the_body_model_measures_itself_is_the_same(middle):
    from anny.anthropometry import Anthropometry

    theirs = body_model("anny")._model  # whose vertices its numbers are of
    phenotypes = MIDDLE | {"age": 0.67, "gender": 0.5, "proportions": 0.5}
    with torch.no_grad():
        rest = theirs(None, {name: torch.tensor([value]).double() for name, value in phenotypes.items()}, {})
    waist = Anthropometry.__new__(Anthropometry)
    numbers = theirs.base_mesh_vertex_indices.tolist()
    from anny.anthropometry import BASE_MESH_WAIST_VERTICES

    waist.waist_vertex_indices = [numbers.index(vertex) for vertex in BASE_MESH_WAIST_VERTICES]
    rest = rest["rest_vertices"]
    assert middle[at("waist_girth_mm")] == pytest.approx(1000 * float(waist.waist_circumference(rest)[0]), abs=1e-4)
    assert middle[at("height_mm")] == pytest.approx(1000 * float(waist.height(rest)[0]), abs=1)
    ours = body_model(TOPOLOGY)
    waist.faces = torch.tensor(ours.faces)
    volume = float(waist.volume(torch.from_numpy(ours.rest(MIDDLE)[0])[None])[0])
    assert middle[at("volume_l")] == pytest.approx(1000 * volume)


def test_measures_are_of_the_person_in_any_pose_and_topology(tmp_path):
    how = {"n": 4, "poses": "random", "scans": 2, "measures": True}
    small, full = Bodies(topology=SMALL, **how), Bodies(jitter=20, **how)
    np.testing.assert_array_equal(small.parameters, full.parameters)
    np.testing.assert_array_equal(small.parameters[0], small.parameters[1])
    assert np.abs(small.parameters[1] - small.parameters[2]).min() > 1e-3
    small.keep_in(Cache(tmp_path))
    again = Bodies(topology=SMALL, **how)
    again.keep_in(Cache(tmp_path))
    np.testing.assert_array_equal(again.parameters, small.parameters)
    assert small.key == Bodies(topology=SMALL, **{**how, "measures": False}).key  # the shapes are the same
    np.testing.assert_array_equal(Remeshed(small, vertices=(300, 400)).parameters, small.parameters)


def test_volume_and_area_are_those_of_the_surface(middle):
    mesh = Bodies(n=1).make(MIDDLE)
    assert middle[at("area_m2")] == pytest.approx(mesh.area, rel=1e-4)
    assert middle[at("volume_l")] == pytest.approx(1000 * enclosed_volume(mesh), rel=1e-4)


@pytest.mark.parametrize(
    ("slider", "name"),
    [*zip(*[("waist", "thigh", "calf", "upper_arm")] * 2, strict=True), ("hips", "hip"), ("bust", "chest")],
)
def test_a_girth_grows_with_its_slider_and_is_what_grows_most(middle, slider, name):
    more = measured([MIDDLE | {slider: 0.9}])[0] / middle
    girths = [place for place, measure in enumerate(MEASURES) if "girth" in measure.name]
    assert more[at(f"{name}_girth_mm")] > 1.05
    assert max(girths, key=lambda place: more[place]) == at(f"{name}_girth_mm")


def test_a_longer_leg_is_longer_inside_and_the_trunk_is_not(middle):
    more = measured([MIDDLE | {"upper_leg_length": 1.0}])[0] - middle
    assert more[at("inside_leg_mm")] == pytest.approx(more[at("height_mm")], abs=1)
    assert abs(more[at("torso_length_mm")]) < 1


def test_a_tape_goes_all_around_its_part():
    """No tape is cut short by the edge of a mask: seen from its middle there is no gap of a quarter turn."""
    for tape in taped(MIDDLE | {"weight": 1.0})[1].values():
        out = tape.points - tape.points.mean(0)
        axes = np.linalg.svd(out, full_matrices=False)[2][:2]
        angles = np.sort(np.arctan2(*(out @ axes.T).T))
        assert np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() < np.pi / 2


def test_names_end_in_units():
    assert [measure.unit for measure in MEASURES[-3:]] == ["mm", "m²", "l"]
    assert MEASURES[1].title == "chest girth"


def test_a_body_scaled_to_unit_area_has_no_millimetres():
    with pytest.raises(InputError, match="measures: expected bodies of their own size"):
        Bodies(n=1, measures=True, normalise_area=True)
