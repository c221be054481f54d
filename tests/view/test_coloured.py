import numpy as np
import pytest
import trimesh
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.util.tensor_util import make_ndarray
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, load
from lssd_learn.view import scenes
from lssd_learn.view.coloured import save_coloured
from lssd_learn.view.fields import Field
from lssd_learn.view.scenes import add_row

BOX = trimesh.creation.box((1, 2, 3))
MESH, CLOUD = Mesh(BOX.vertices, BOX.faces), PointCloud(BOX.vertices)
FIELD = Field.signed("f", "f", [BOX.vertices[:, 2]] * 2)


@pytest.mark.parametrize("shape", [MESH, CLOUD])
@pytest.mark.parametrize("suffix", [".ply", ".glb"])
def test_colours_arrive_and_only_glb_is_turned(shape, suffix, tmp_path):
    path = tmp_path / f"box{suffix}"
    save_coloured(shape, FIELD.colours(0), path, "z")
    read = load(path)
    height = 1 if suffix == ".glb" else 2
    assert np.ptp(read.vertices[:, height]) == pytest.approx(3)
    assert type(read) is type(shape)
    loaded = trimesh.load(path, process=False)
    (part,) = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    seen = part.visual.vertex_colors if isinstance(part, trimesh.Trimesh) else part.colors
    np.testing.assert_array_equal(np.asarray(seen)[:, :3], FIELD.colours(0))


@pytest.mark.parametrize("suffix", [".ply", ".glb"])
def test_far_from_the_origin_no_vertices_fall_together(suffix, tmp_path):
    """In float32 a box at geocentric coordinates is a point or two."""
    far = np.array([3.9e6, 1.1e6, 4.9e6])
    path = tmp_path / f"box{suffix}"
    save_coloured(Mesh(0.1 * BOX.vertices + far, BOX.faces), FIELD.colours(0), path)
    np.testing.assert_allclose(load(path).vertices - far, 0.1 * BOX.vertices, atol=1e-6)


def test_other_files_are_refused(tmp_path):
    for path in (tmp_path / "box.obj", tmp_path / "nowhere" / "box.ply"):
        with pytest.raises(InputError, match="expected a .ply or .glb in a folder that exists"):
            save_coloured(MESH, FIELD.colours(0), path)


@pytest.mark.parametrize(("most", "shapes"), [(100, 2), (10, 1)])
def test_a_scene_holds_as_many_shapes_as_it_can(tmp_path, monkeypatch, most, shapes):
    monkeypatch.setattr(scenes, "MOST", most)
    with SummaryWriter(tmp_path) as writer:
        add_row(writer, "row", [MESH, MESH], "z", FIELD.colours)
    events = EventAccumulator(str(tmp_path))
    events.Reload()
    vertices, faces, colours = (make_ndarray(events.Tensors(f"row_{k}")[0].tensor_proto)[0]
                                for k in ("VERTEX", "FACE", "COLOR"))  # fmt: skip
    assert (len(vertices), faces.max()) == (8 * shapes, 8 * shapes - 1)
    assert np.ptp(vertices[:, 1]) == pytest.approx(3)
    np.testing.assert_array_equal(colours[:8], FIELD.colours(0))
