"""Work that goes shape by shape gives the same bits wherever it is done."""

import sys

import numpy as np
import pytest
from joblib import parallel_config

from lssd_learn.cluster import cluster, is_on_cluster
from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.pipeline import Pipeline


@pytest.fixture(scope="module")
def operators():
    """A function → the operators of a few small bodies, made anew by two processes or by the workers of a cluster."""
    bodies = Bodies(8, topology="notoes_collapse5pc")
    sizes = {"k": 16, "size": 12, "keep": 8, "cache": None, "workers": 2}
    return lambda: Pipeline(bodies, **sizes).operators(("area", "conformal")).numpy()


def test_a_backend_of_ones_own_is_used(operators):
    assert not is_on_cluster()
    with parallel_config("threading"):
        assert is_on_cluster()
        elsewhere = operators()
    np.testing.assert_array_equal(elsewhere, operators())


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("backend", "package"), [("dask", "distributed"), ("ray", "ray")])
def test_a_cluster_gives_the_same_bits(operators, backend, package):
    pytest.importorskip(package)
    with cluster(backend):
        assert is_on_cluster()
        elsewhere = operators()
    assert not is_on_cluster()
    np.testing.assert_array_equal(elsewhere, operators())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("slurm",), "parallel.backend=slurm: expected one of local, dask, ray"),
        (("local", "tcp://a:1"), "parallel.address=tcp://a:1: expected parallel=dask or parallel=ray with it"),
    ],
)
def test_what_is_no_cluster_is_refused(arguments, message):
    with pytest.raises(InputError, match=message), cluster(*arguments):
        pass


@pytest.mark.parametrize(("backend", "package"), [("dask", "distributed"), ("ray", "ray")])
def test_what_is_not_installed_is_named(monkeypatch, backend, package):
    monkeypatch.setitem(sys.modules, package, None)
    wanted = rf"parallel={backend}: .* is not installed: pip install 'lssd_learn\[{backend}\]'"
    with pytest.raises(InputError, match=wanted), cluster(backend):
        pass
