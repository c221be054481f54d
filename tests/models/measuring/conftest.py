import pytest

from lssd_learn.collections import People
from lssd_learn.models.measuring.figure import Figure
from lssd_learn.tasks.reader import learnt_from


@pytest.fixture(scope="session")
def known():
    """A few people, and how they vary and bend."""
    return learnt_from(People(n=24))


@pytest.fixture(scope="session")
def figure(known):
    return Figure.of(known, 12)
