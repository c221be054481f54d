"""LSSD as an estimator: the numbers of the pipeline, the contract of scikit-learn."""

import pickle
from functools import partial

import numpy as np
import pytest
import torch
import trimesh
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.linear_model import Ridge
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.utils import _safe_indexing, estimator_checks
from sklearn.utils.validation import check_is_fitted, validate_data

from lssd_learn.collections import ShapeList, as_collection
from lssd_learn.errors import InputError
from lssd_learn.estimator import LSSD, NETWORKS
from lssd_learn.latent import MapNetwork
from lssd_learn.maps import RegistrationMaps
from lssd_learn.operators import logarithm
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, PointCloud, save

SIZES = {"k": 20, "size": 14, "keep": 8}


@pytest.fixture(scope="module")
def shapes(deformed_spheres):
    return deformed_spheres(12, 2)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("estimator")


@pytest.fixture
def lssd(cache):
    return partial(LSSD, **SIZES, cache=cache)


def test_it_has_the_numbers_of_the_pipeline(lssd, shapes):
    expected = Pipeline(shapes, **SIZES, cache=None).operators(["area", "conformal"])
    estimator = lssd().fit(shapes)
    np.testing.assert_allclose(estimator.matrices(shapes), expected, atol=1e-5)  # of eigenbases kept in float32
    assert estimator.latent_.keep == 8
    np.testing.assert_allclose(lssd().fit_transform(shapes), estimator.transform(shapes))


def test_vectors_have_the_inner_products_of_the_matrices_or_of_their_logarithms(lssd, shapes):
    D = torch.from_numpy(lssd().fit(shapes).matrices(shapes))
    logs = torch.stack([logarithm(D[:, 0]), logarithm(D[:, 1])], 1)
    for features, expected in (("matrices", D), ("logarithms", logs)):
        estimator = lssd(features=features).fit(shapes)
        X = estimator.transform(shapes)
        flat = expected.flatten(1).numpy()
        np.testing.assert_allclose(X @ X.T, flat @ flat.T, rtol=1e-6, atol=1e-9)
        names = estimator.get_feature_names_out()
        assert X.shape == (12, len(names)) == (12, 72)
        assert names[1].endswith("area_0_1")
        assert names[-1].endswith("conformal_7_7")
    np.testing.assert_allclose(X[:, 1], np.sqrt(2) * logs[:, 0, 0, 1])


def test_new_shapes_are_pushed_and_the_old_ones_keep_their_own(lssd, shapes):
    estimator, whole = lssd().fit(shapes[:10]), lssd().fit(shapes)
    mixed = estimator.matrices([shapes[11], shapes[3]])
    np.testing.assert_allclose(mixed[1], estimator.matrices(shapes[:10])[3], atol=1e-12)
    area, expected = mixed[0, 0], whole.matrices(shapes)[11, 0]
    spectra = [np.linalg.eigvalsh(D) for D in (area, expected)]
    assert np.abs(spectra[0] - spectra[1]).max() < 0.3 * np.abs(spectra[1] - 1).max()
    assert estimator.matrices(shapes[10:]).shape == (2, 2, 8, 8)


def test_strangers_are_mapped_by_a_search_or_by_maps_that_were_named(lssd, shapes):
    order = np.random.default_rng(0).permutation(162)
    stranger = Mesh(shapes[2].vertices[order], np.argsort(order)[shapes[2].faces])
    own = lssd().fit(shapes).matrices(shapes)[:, 0]
    found = {maps: lssd(maps=maps).fit(shapes).matrices([stranger])[0, 0] for maps in ("auto", "registration")}
    for area in found.values():
        assert np.linalg.norm(own - area, axis=(1, 2)).argmin() == 2
    by_class = lssd(maps=RegistrationMaps).fit(shapes).matrices([stranger])[0, 0]
    np.testing.assert_array_equal(by_class, found["registration"])
    with pytest.raises(InputError, match="0: expected a mesh in vertex correspondence"):
        lssd(maps="correspondence").fit(shapes).transform([stranger])


def test_shapes_come_in_any_form(lssd, shapes, tmp_path):
    expected = lssd().fit(shapes).transform(shapes)
    pair, theirs = (shapes[0].vertices, shapes[0].faces), trimesh.Trimesh(shapes[1].vertices, shapes[1].faces)
    save(shapes[2], tmp_path / "c.off")
    given = [pair, theirs, tmp_path / "c.off", *shapes[3:]]
    np.testing.assert_allclose(lssd().fit_transform(given), expected, atol=1e-6)
    collection = ShapeList(shapes)  # without a key: nothing is cached or known again
    np.testing.assert_allclose(lssd().fit(collection).transform(collection), expected, atol=0.2)


def test_it_sits_in_a_pipeline_and_a_cross_validation(lssd, shapes):
    size = np.array([np.ptp(shape.vertices[:, 2]) for shape in shapes])
    scores = cross_val_score(make_pipeline(lssd(), Ridge(1e-3)), shapes, size, cv=3)
    assert scores.shape == (3,)
    collection = as_collection(shapes)
    collection.landmarks = [{"top": i} for i in range(12)]
    fold = _safe_indexing(collection, np.array([5, 2]))  # what a cross-validation makes of it
    assert [marks["top"] for marks in fold.landmarks] == [5, 2]
    assert fold.shape_key(1) == collection.shape_key(2)
    whole = cross_val_score(make_pipeline(lssd(), Ridge(1e-3)), collection, size, cv=3)
    np.testing.assert_allclose(whole, scores, rtol=1e-4)
    fitted = make_pipeline(lssd(), Ridge(1e-3)).fit(shapes[:9], size[:9])
    np.testing.assert_allclose(fitted.predict(shapes[:9]), size[:9], atol=0.05)
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict(shapes[9:]), fitted.predict(shapes[9:]))


def test_parameters_are_got_set_and_cloned(lssd):
    estimator = lssd(network=partial(MapNetwork.nearest, neighbours=3), operators=("area",))
    copy = clone(estimator.set_params(keep=5))
    assert copy.get_params().keys() == LSSD().get_params().keys()
    assert (copy.keep, copy.operators, copy.network.keywords) == (5, ("area",), {"neighbours": 3})
    with pytest.raises(NotFittedError):
        copy.transform([])


@pytest.mark.parametrize("network", [name for name in NETWORKS if name != "nearest_20"])  # of 12 shapes
def test_a_network_goes_by_its_name(lssd, shapes, network):
    assert lssd(network=network, operators=["area"]).fit_transform(shapes).shape == (12, 36)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"network": "ring"}, r"network='ring': expected one of clique, nearest_10, .* or a function of bases"),
        ({"maps": "guess"}, r"maps='guess': expected one of auto, correspondence, .* or a class of maps"),
        ({"features": "flat"}, "features='flat': expected one of logarithms, matrices"),
        ({"operators": ["volume"]}, "operators"),
        ({"keep": 99}, "keep=99: expected 1 to size=14"),
    ],
)
def test_a_wrong_argument_is_told_when_it_is_fitted(lssd, shapes, given, message):
    with pytest.raises(InputError, match=message):
        lssd(**given).fit(shapes)


def test_one_shape_or_numbers_are_no_shapes(lssd, shapes):
    for X, message in (
        (shapes[0], "got one Mesh: write"),
        (np.eye(4), r"shapes\[0\]: expected a Mesh"),
        ([], "expected 2"),
    ):
        with pytest.raises(InputError, match=message):
            lssd().fit(X)
    with pytest.raises(InputError, match="expected one or more, got none"):
        lssd().fit(shapes).transform([])


class OnRows(LSSD):
    """An LSSD that reads a table, each row a sphere that these numbers bend: what check_estimator can feed."""

    def __init__(self, k=6, size=5, keep=4, operators=("area",), features="matrices"):
        super().__init__(k, size, keep, operators=operators, features=features, cache=None)

    def fit(self, X, y=None):
        return super().fit(self._spheres(validate_data(self, X, ensure_min_samples=2)), y)

    def matrices(self, X):
        check_is_fitted(self)
        return super().matrices(self._spheres(validate_data(self, X, reset=False)))

    def _spheres(self, X):
        sphere = trimesh.creation.icosahedron()
        directions = np.random.default_rng(0).normal(size=(X.shape[1], 3))
        waves = np.cos(2 * directions @ sphere.vertices.T) / (4 * X.shape[1])
        bends = [np.tanh(x) @ waves for x in np.asarray(X, dtype=float)]  # one by one: the same bits in any company
        shapes = [Mesh((1.5 + bend)[:, None] * sphere.vertices, sphere.faces) for bend in bends]
        return as_collection(shapes)

    def get_feature_names_out(self, input_features=None):
        if input_features is not None and list(input_features) != list(getattr(self, "feature_names_in_", ())):
            raise ValueError("input_features is not equal to feature_names_in_")
        return super().get_feature_names_out()

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.two_d_array, tags.no_validation = True, False
        return tags


# Checks that feed no data.
NO_TABLE = (
    "parameters_default_constructible",
    "no_attributes_set_in_init",
    "estimator_cloneable",
    "estimator_repr",
    "get_params_invariance",
    "set_params",
    "mixin_order",
    "valid_tag_types",
    "do_not_raise_errors_in_init_or_set_params",
)


@pytest.mark.slow
def test_the_checks_of_scikit_learn_pass():
    results = estimator_checks.check_estimator(OnRows(), on_fail=None, on_skip=None)
    failed = {result["check_name"]: result["exception"] for result in results if result["status"] == "failed"}
    assert failed == {}
    assert sum(result["status"] == "passed" for result in results) > 40


def test_those_that_need_no_table_pass_on_shapes():
    for check in NO_TABLE:
        getattr(estimator_checks, f"check_{check}")("LSSD", LSSD())


def test_clouds_are_shapes_too(lssd, shapes):
    clouds = [PointCloud(shape.vertices) for shape in shapes[:3]]
    with pytest.raises(InputError, match="not in vertex correspondence"):
        lssd(maps="correspondence").fit(clouds)
