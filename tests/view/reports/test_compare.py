"""What the page of a comparison says in words."""

import numpy as np

from lssd_learn.collections.groups import ChosenGroups
from lssd_learn.view.reports.compare import size_words


def test_groups_of_other_sizes_are_told_and_others_are_not():
    groups = ChosenGroups("kind", ["a", "b"], np.arange(8), [*"aaaabbbb"])
    noise = np.array([1.0, 1.1, 0.9, 1.05] * 2)
    assert size_words(noise, groups) == ""
    said = size_words(noise * np.repeat([1, 2], 4), groups)
    assert "total area: a 1.01, b 2.02" in said
    assert "collection.normalise_area=true" in said
    assert size_words(np.ones(8), groups) == ""  # brought to one area
