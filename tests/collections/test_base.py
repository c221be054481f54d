import numpy as np

from lssd_learn.collections import ShapeList, as_collection
from lssd_learn.shapes import PointCloud


def test_a_plain_list_is_a_collection():
    clouds = [PointCloud(np.full((2, 3), i)) for i in range(3)]
    collection = as_collection(clouds)
    assert isinstance(collection, ShapeList)
    assert list(collection) == clouds
    assert collection.names == ["0", "1", "2"]
    assert (collection.parameters, collection.up) == (None, None)
    assert not collection.check()
    assert as_collection(collection) is collection
