"""Long work is foretold from the first few maps."""

import logging
from itertools import combinations

import pytest

from lssd_learn.maps import pace
from lssd_learn.maps.stored import StoredMaps


class Clock:
    """Every map takes so many seconds."""

    def __init__(self, seconds, monkeypatch):
        self.now, self.seconds, self.asked = 0.0, seconds, []
        monkeypatch.setattr(pace.time, "monotonic", lambda: self.now)

    def compute(self, p):
        self.now += self.seconds
        self.asked.append(p)
        return p


def test_a_clique_of_sixty_shapes_is_told_and_hubs_are_offered(monkeypatch, caplog):
    clock = Clock(1.4, monkeypatch)
    assert pace.timed(clock.compute, list(combinations(range(60), 2)), workers=2) == [0, 1, 2]
    (line,) = caplog.messages
    assert line == (
        "1770 maps at 1.4 s each will take 41 minutes on one core, 21 minutes on 2; network=hubs needs 230 of them, "
        "5.4 minutes"
    )


def test_hubs_are_not_offered_to_hubs_and_short_work_is_not_told(monkeypatch, caplog):
    hubs = [(h, i) for h in range(4) for i in range(h + 1, 300)]
    assert len(hubs) == 4 * 299 - 6
    pace.timed(Clock(1.0, monkeypatch).compute, hubs, workers=1)
    (line,) = caplog.messages
    assert line == "1190 maps at 1 s each will take 20 minutes on one core"
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert pace.timed(Clock(0.1, monkeypatch).compute, hubs, workers=1) == [0, 1, 2]
        clock = Clock(50, monkeypatch)
        assert pace.timed(clock.compute, hubs[:9], workers=1) == []
    assert not caplog.messages
    assert not clock.asked


class Maker:
    """Keeps count of what it is asked for."""

    def __init__(self):
        self.asked = []

    def pair(self, i, j):
        self.asked.append((i, j))
        return {"there": [i], "back": [j]}

    def depends_on(self, i, j):
        return []


@pytest.mark.parametrize("kept", [False, True])
def test_the_maps_that_were_timed_are_kept(cache, kept):
    stored, maker = StoredMaps(cache, lambda i, j, more: f"{i}-{j}") if kept else StoredMaps(), Maker()
    pairs = list(combinations(range(8), 2))
    stored.prepare(maker, pairs, workers=1)
    assert maker.asked == pairs
    assert stored(maker, 0, 1)[0].tolist() == [0]
    assert stored(maker, 6, 7)[1].tolist() == [7]
    assert maker.asked == pairs
