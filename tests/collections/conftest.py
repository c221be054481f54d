import pytest

from lssd_learn.collections import Bodies


@pytest.fixture(scope="session")
def bodies():
    """Sixteen small bodies; the body model is loaded once a session, by whoever first asks for a shape."""
    return Bodies(n=16, seed=3, topology="notoes_collapse5pc")
