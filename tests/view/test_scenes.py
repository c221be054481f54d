import json

import numpy as np
import pytest
import trimesh
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.plugins.mesh import metadata
from tensorboard.util.tensor_util import make_ndarray
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.view import scenes
from lssd_learn.view.scenes import add_row, side_by_side, upright


def pillar(height, x=0.0):
    """A box that stands along z, its front towards -y."""
    box = trimesh.creation.box((1, 0.5, height))
    return Mesh(box.vertices + [x, 0, 3], box.faces)


@pytest.fixture
def scene(tmp_path):
    """A function (shapes, up) → vertices, faces or None, settings of the scene, as TensorBoard reads them."""

    def write(shapes, up="z"):
        with SummaryWriter(tmp_path) as writer:
            add_row(writer, "row", shapes, up)
        events = EventAccumulator(str(tmp_path))
        events.Reload()
        read = {t: make_ndarray(events.Tensors(t)[0].tensor_proto)[0] for t in events.Tags()["tensors"]}
        content = events.SummaryMetadata("row_VERTEX").plugin_data.content
        settings = json.loads(metadata.parse_plugin_metadata(content).json_config or "{}")
        return read["row_VERTEX"], read.get("row_FACE"), settings

    return write


def test_z_up_becomes_y_up_and_the_front_comes_towards_the_viewer():
    front, top = [0, -1, 0], [0, 0, 1]
    np.testing.assert_array_equal(upright([front, top], "z"), [[0, 0, 1], [0, 1, 0]])
    np.testing.assert_array_equal(upright([front, top], None), [front, top])
    np.testing.assert_array_equal(upright([front, top], "y"), [front, top])


def test_shapes_stand_beside_each_other_on_one_ground(scene):
    vertices, faces, _ = scene([pillar(2), pillar(4, x=-9), pillar(3)])
    assert faces.max() == 23
    parts = vertices.reshape(3, 8, 3)
    np.testing.assert_allclose(np.ptp(parts, axis=1), [[1, h, 0.5] for h in (2, 4, 3)], atol=1e-6)
    np.testing.assert_allclose(parts[..., 1].min(1), 0, atol=1e-6)
    assert (parts[:-1, :, 0].max(1) < parts[1:, :, 0].min(1)).all()  # in their order, none in another
    areas = trimesh.Trimesh(vertices, faces, process=False).split()
    assert [piece.volume for piece in areas] == pytest.approx([1, 2, 1.5], rel=1e-5)  # faces look outwards


def test_a_cloud_is_upright_too_and_its_points_can_be_seen(scene):
    vertices, faces, settings = scene([PointCloud(pillar(2).vertices), pillar(5)])
    assert faces is None
    assert vertices.shape == (16, 3)
    assert np.ptp(vertices[8:, 1]) == pytest.approx(5)
    assert 0.005 * 5 < settings["material"]["size"] < 0.05 * 5


def test_the_plugin_counts_vertices_in_sixteen_bits(scene, monkeypatch):
    monkeypatch.setattr(scenes, "MOST", 20)
    vertices, faces, _ = scene([pillar(2), pillar(3), pillar(4)])
    assert (len(vertices), faces.max()) == (16, 15)


def test_a_mesh_too_large_for_the_plugin_is_shown_as_points(scene, monkeypatch):
    monkeypatch.setattr(scenes, "MOST", 7)
    vertices, faces, _ = scene([pillar(2), pillar(3)])
    assert (len(vertices), faces) == (8, None)


def test_a_flat_or_single_point_is_placed():
    (alone,) = side_by_side([np.array([[1.0, 2.0, 3.0]])])
    np.testing.assert_array_equal(alone, [[0, 0, 0]])
