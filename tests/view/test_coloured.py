import base64
import re

import numpy as np
import pytest
import trimesh
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.util.tensor_util import make_ndarray
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, load, read
from lssd_learn.view import scenes
from lssd_learn.view.coloured import save_coloured, save_fields
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


@pytest.mark.parametrize("shape", [MESH, CLOUD])
def test_values_arrive_by_their_names(shape, tmp_path):
    other = Field.positive("g", "g", [np.arange(8.0)] * 2)
    save_fields(shape, [FIELD, other], 1, tmp_path / "box.vtp", "RAS")
    assert read(tmp_path / "box.vtp").space == "RAS"
    assert type(load(tmp_path / "box.vtp")) is type(shape)
    text = (tmp_path / "box.vtp").read_text()

    def array(name, kind):
        (content,) = re.findall(f'Name="{name}"[^>]*>([^<]*)<', text)
        return np.frombuffer(base64.b64decode(content)[8:], kind)

    np.testing.assert_array_equal(array("g", "<f8"), np.arange(8))
    np.testing.assert_array_equal(array("f", "<f8"), FIELD.values[1])
    np.testing.assert_array_equal(array("f_colours", "u1").reshape(-1, 3), FIELD.colours(1))
    save_coloured(shape, FIELD.colours(0), tmp_path / "box.ply", values={"f": FIELD.values[0]}, space="LPS")
    assert read(tmp_path / "box.ply").space == "LPS"
    body = (
        (tmp_path / "box.ply")
        .read_bytes()
        .split(b"property uchar blue\nproperty double f\n")[1]
        .split(b"end_header\n")[1]
    )
    np.testing.assert_array_equal(
        np.frombuffer(body, "u1", 8 * 35).reshape(8, 35)[:, 27:].copy().view("<f8")[:, 0], FIELD.values[0]
    )


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
