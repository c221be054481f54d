import numpy as np
import trimesh
from matplotlib.backends.backend_agg import FigureCanvasAgg
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lssd_learn.shapes import Mesh, PointCloud, load
from lssd_learn.view.exports import export
from lssd_learn.view.sheets import shape_sheet, write_sheets


def ball(height=1.0):
    sphere = trimesh.creation.icosphere(2)
    return Mesh(sphere.vertices * [0.3, 0.3, height], sphere.faces)


def pixels(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]


def test_rows_columns_and_empty_places():
    rows = {"truth": {"a": ball(), "b": None, "c": ball(0.5)}, "drawn": {"a": ball(), "b": ball(), "c": ball()}}
    figure = shape_sheet(rows, "z", size=100)
    (axes,) = figure.axes
    (image,) = axes.get_images()
    dark = (np.asarray(image.get_array()) < 250).any(-1)
    down, across = (np.array_split(np.arange(n), k) for n, k in zip(dark.shape, (2, 3), strict=True))
    counts = np.array([[dark[np.ix_(r, c)].sum() for c in across] for r in down])
    assert counts[0, 1] == 0
    assert (counts > 0).sum() == 5
    assert counts[0, 2] < 0.7 * counts[0, 0]  # one scale for all
    assert [text.get_text() for text in axes.texts] == ["a", "b", "c"]  # once, as they are the same below
    assert [label.get_text() for label in axes.get_yticklabels()] == ["truth", "drawn"]


def test_the_titles_of_rows_are_not_cut_off():
    image = pixels(shape_sheet({"a long title of a row": {"": ball()}}, "z", size=100))
    assert (image[:, :3] == 255).all()
    assert (image[:, : image.shape[1] // 2] < 128).any()


def test_a_page_replaces_the_one_before(tmp_path):
    for _ in range(2):
        write_sheets(tmp_path, {"sheet": shape_sheet({"x": {"y": ball()}}, "z", size=50)}, {"scene": [ball()]}, "z")
    events = EventAccumulator(str(tmp_path))
    events.Reload()
    assert len(list(tmp_path.glob("*.sheets"))) == 1
    assert events.Tags()["images"] == ["sheet"]
    assert any(tag.startswith("scene") for tag in events.Tags()["tensors"])


def test_files_of_meshes_and_clouds(tmp_path):
    for name, shape in {"a:b c": ball(), "cloud": PointCloud(ball().vertices)}.items():
        export(shape, tmp_path / "new", name, "z")
        plain = name.replace(":", "_").replace(" ", "_")
        np.testing.assert_allclose(load(tmp_path / "new" / f"{plain}.ply").points, shape.points, atol=1e-6)
        viewed = load(tmp_path / "new" / f"{plain}.glb")
        np.testing.assert_allclose(np.ptp(viewed.points, axis=0), np.ptp(shape.points, axis=0)[[0, 2, 1]], atol=1e-5)
        assert isinstance(viewed, type(shape))
