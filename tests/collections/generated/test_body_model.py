import logging

from lssd_learn.collections.generated.body_model import _announce_building


def test_building_is_announced_once(caplog, capfd):
    chatter = logging.getLogger("anny.models.model_data")
    with caplog.at_level(logging.INFO), _announce_building():
        chatter.info("Loading cached model data from x")
        assert caplog.messages == []
        chatter.info("No cached model data found at x, building model data...")
        chatter.info("No cached model data found at y, building model data...")
    assert caplog.messages == ["building the body model, about a minute, once"]
    assert capfd.readouterr() == ("", "")
    assert logging.getLogger("anny").propagate
