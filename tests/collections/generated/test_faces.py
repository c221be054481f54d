import pickle
import subprocess
import sys

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lssd_learn.app import conf
from lssd_learn.collections import Faces
from lssd_learn.collections.generated.expressions import EXPRESSIONS, facial_actions
from lssd_learn.errors import InputError

MIDDLE = np.full(16, 0.5)


@pytest.fixture(scope="module")
def faces():
    return Faces(2, tuple(EXPRESSIONS))


def test_nothing_but_a_shape_loads_the_model():
    code = (
        "import sys; from lssd_learn.collections import Faces; f = Faces(3); "
        "len(f), f.names, f.parameters, f.groups, f.key, f.shape_key(3), f.up; "
        "assert not {'anny', 'torch', 'warp'} & set(sys.modules), 'loaded'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_is_known():
    faces = Faces(3)
    assert faces.names[:3] == ["face_00_happy", "face_00_sad", "face_01_happy"]
    assert faces.groups["expression"].tolist() == ["happy", "sad"] * 3
    assert faces.groups["identity"].tolist() == ["face_00"] * 2 + ["face_01"] * 2 + ["face_02"] * 2
    assert faces.parameters.shape == (6, len(faces.parameter_names)) == (6, 16)
    np.testing.assert_array_equal(faces.parameters[0], faces.parameters[1])
    assert (faces.parameters[1] != faces.parameters[2]).all()


def test_heads_are_one_piece_with_an_open_neck(faces):
    mesh = faces[1]
    assert (mesh.vertices.shape, mesh.connectivity) == ((4200, 3), faces[7].connectivity)
    directed = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)  # a manifold, oriented one way
    edges, times = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    rim = edges[times == 1]
    assert mesh.vertices[rim, 2].max() < np.quantile(mesh.vertices[:, 2], 0.1)
    graph = coo_array((np.ones(len(rim)), rim.T), shape=(4200, 4200))
    _, pieces = connected_components(graph, directed=False)
    assert (np.bincount(pieces) > 1).sum() == 1  # and nothing else is open
    assert 4200 - len(edges) + len(mesh.faces) == 1  # a disc
    assert 0.15 < np.ptp(mesh.vertices[:, 1]) < 0.25  # metres, from nose to nape


def test_corners_of_the_mouth_go_up_in_a_smile_and_down_in_a_frown(faces):
    neutral, happy, sad = (faces.make(MIDDLE, e).vertices for e in ("neutral", "happy", "sad"))
    smile = happy[:, 2] - neutral[:, 2]
    corners = np.argsort(-smile)[:40]  # what a smile lifts most
    assert (neutral[corners, 1] < neutral[:, 1].mean()).all()  # is in front
    assert np.abs(neutral[corners, 0].mean()) < 0.3 * np.abs(neutral[corners, 0]).mean()  # and on both sides
    assert smile[corners].min() > 0.004 > -0.004 > (sad[corners, 2] - neutral[corners, 2]).mean()


def test_expressions_change_the_face_and_identities_the_head(faces):
    back = faces[0].vertices[:, 1] > np.quantile(faces[0].vertices[:, 1], 0.8)
    front = ~back
    one, other = faces[1].vertices - faces[0].vertices, faces[6].vertices - faces[0].vertices
    assert np.abs(one[back]).max() < 0.0005 < 0.005 < np.abs(one[front]).max()
    assert np.abs(other[back]).max() > 0.005


def test_a_face_depends_on_nothing_but_itself(faces):
    few = Faces(1, ("sad",))
    assert few.shape_key(0) == faces.shape_key(2) != faces.shape_key(8)
    np.testing.assert_array_equal(few[0].vertices, faces[2].vertices)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(few))[-1].vertices, faces[2].vertices)
    others = [Faces(1, seed=1), Faces(1, weakened=0.2), Faces(1, normalise_area=True), Faces(2)]
    assert len({faces.key, Faces(1).key, *(other.key for other in others)}) == 6
    assert Faces(1, ("happy",), normalise_area=True)[0].area == pytest.approx(1)


def test_strengths_differ_within_their_bounds(faces):
    exact = Faces(1, ("happy",), weakened=0)
    np.testing.assert_array_equal(exact[0].vertices, exact.make(exact.parameters[0], "happy").vertices)
    actions, full = faces._actions(0, "happy"), facial_actions("happy")
    shares = np.array([actions[name] / full[name] for name in full])
    assert actions.keys() == full.keys()
    assert 0.7 <= shares.min() < shares.max() <= 1
    assert len(set(shares)) == len(shares)
    with pytest.raises(IndexError):
        exact[1]


def test_every_expression_is_made_of_actions_there_are(faces):
    for name in EXPRESSIONS:
        assert faces.make(MIDDLE, name).vertices.shape == (4200, 3)


def test_the_configuration_is_the_default():
    faces = instantiate(OmegaConf.load(conf() / "collection" / "faces.yaml"))
    assert (faces.key, faces.names) == (Faces().key, Faces().names)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"identities": 0}, "identities=0: expected a whole number, 1 or more"),
        ({"seed": -1}, "seed=-1: expected a whole number, 0 or more"),
        ({"expressions": ("happy", "mad")}, "expressions: expected some of neutral, .*, each once; got happy, mad"),
        ({"expressions": ("sad", "sad")}, "each once; got sad, sad"),
        ({"expressions": ()}, "got none"),
        ({"weakened": 1.5}, "weakened: expected a share, 0 to 1, got 1.5"),
        ({"weakened": True}, "weakened: expected a share, 0 to 1, got True"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        Faces(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((MIDDLE[:3],), "parameters: expected 16 values"),
        ((MIDDLE + 1,), "parameters: expected 16 values"),
        ((MIDDLE, "mad"), "expression: expected one of neutral, happy, .*, got 'mad'"),
        ((MIDDLE, {"mouthSmile": 1}), "expression: expected actions of browDownLeft, .*, got 'mouthSmile'"),
        ((MIDDLE, {"jawOpen": 2}), r"expression: expected jawOpen in \[0, 1\], got 2"),
    ],
)
def test_faces_that_cannot_be_made(faces, arguments, message):
    with pytest.raises(InputError, match=message):
        faces.make(*arguments)
