import logging

import numpy as np

from lssd_learn.collections.generated.body.model import LOCAL_CHANGES, _announce_building, body_model


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


def test_one_half_is_neutral():
    """The local changes of a body whose parameters are all .5 are none at all."""
    model = body_model("notoes_collapse5pc")
    phenotypes = {"muscle": 0.5, "weight": 0.5, "height": 0.5}
    plain = model.vertices(phenotypes, "rest")
    np.testing.assert_allclose(model.vertices(phenotypes | dict.fromkeys(LOCAL_CHANGES, 0.5), "rest"), plain, atol=1e-9)
    for name in LOCAL_CHANGES:  # and either side of it changes the body, by about as much
        low, high = (model.vertices(phenotypes | {name: p}, "rest") - plain for p in (0.4, 0.6))
        assert np.vdot(low, high) < 0
