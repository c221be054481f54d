import time

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.collections.groups import choose_group, choose_groups, encode
from lssd_learn.errors import InputError


@pytest.mark.parametrize("group", [None, "parity"])
def test_a_group_is_chosen(group):
    shapes = ShapeList([])
    with pytest.raises(InputError, match="task.group: expected shapes with groups; this collection has none"):
        choose_group(shapes, group, "task.group")
    shapes.groups = {"parity": np.arange(2)}
    assert choose_group(shapes, group, "task.group") == "parity"
    shapes.groups = {"parity": np.arange(2), "2024": np.arange(2)}
    assert choose_group(shapes, 2024, "task.group") == "2024"
    with pytest.raises(InputError, match="task.group: expected one of parity, 2024"):
        choose_group(shapes, None, "task.group")
    with pytest.raises(InputError, match="task.group=half: expected one of parity, 2024"):
        choose_group(shapes, "half", "task.group")


@pytest.mark.parametrize(
    ("labels", "classes", "places"),
    [
        ([7, -1, 7], [-1, 7], [1, 0, 1]),
        (["b", "a", "b"], ["a", "b"], [1, 0, 1]),
        (np.array(["x", 2], dtype=object), ["2", "x"], [1, 0]),
        ([True, False], ["False", "True"], [1, 0]),
    ],
)
def test_classes_are_plain_values_in_order(labels, classes, places):
    found, indices = encode(labels)
    assert found == classes
    assert [type(c) for c in found] == [type(c) for c in classes]
    assert (indices.tolist(), indices.dtype) == (places, np.int64)


def test_many_groups_are_counted_once():
    """A grouping with as many labels as pairs of shapes, and blocks as many: no list is searched for each label."""
    shapes = ShapeList([])
    pairs, blocks = np.arange(50_000) // 2, np.arange(50_000)
    shapes.groups = {"pair": pairs, "block": blocks}
    begin = time.process_time()
    groups = choose_groups(shapes, "pair", blocks="block")
    assert time.process_time() - begin < 2
    assert len(groups.labels) == 25_000
    assert len(groups.shapes) == len(groups.of) == len(groups.blocks) == 50_000
    shapes.groups["block"] = pairs
    with pytest.raises(InputError, match="task.blocks=block: expected two blocks or more .* got one of '0'"):
        choose_groups(shapes, "pair", blocks="block")
