import numpy as np
import pytest
import trimesh

from lssd_learn.shapes import Mesh
from lssd_learn.view import highlights
from lssd_learn.view.embeddings import Panel, embedding_chart, label_colours
from lssd_learn.view.fields import Field
from lssd_learn.view.highlights import highlight_chart


@pytest.mark.parametrize("up", ["z", None])
def test_front_and_back_of_each_shape_beside_each_other(up):
    """A ball that is red in front: the first of two cells shows red, the second does not."""
    ball = trimesh.creation.icosphere(3)
    front = -ball.vertices[:, 1] if up == "z" else ball.vertices[:, 2]
    field = Field.squared("f", "where", [np.maximum(front, 0)[:, None]])
    figure = highlight_chart([Mesh(ball.vertices, ball.faces)], ["a ball"], [field], up)
    row = np.asarray(figure.axes[0].images[0].get_array()).astype(int)
    red = row[..., 0] > row[..., 1] + 60
    middle = row.shape[1] // 2
    assert red[:, :middle].mean() > 0.2
    assert red[:, middle:].sum() == 0


def test_a_row_a_field_with_a_colour_bar_each(meshes, monkeypatch):
    monkeypatch.setattr(highlights, "LARGEST", 100)  # small pictures are quick ones
    fields = [
        Field.signed("f", "sides", [mesh.vertices[:, 0] for mesh in meshes[:3]]),
        Field.squared("g", "height", [mesh.vertices[:, 2:] for mesh in meshes[:3]]),
    ]
    figure = highlight_chart(meshes[:3], list("abc"), fields)
    assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == ["sides", "height"]
    assert [text.get_text() for text in figure.axes[1].get_xticklabels()] == list("abc")
    assert len(figure.axes) == 4
    for axes in figure.axes[:2]:  # front and back of three shapes, each in a cell of its own
        row = np.asarray(axes.images[0].get_array()).astype(int)[..., :3]
        shares = [(cell < 250).any(axis=2).mean() for cell in np.array_split(row, 6, axis=1)]
        assert min(shares) > 0.3


def test_embeddings_side_by_side(tmp_path):
    rng = np.random.default_rng(0)
    panels = [Panel(rng.normal(size=(5, 2)), [0.7, 0.2], title) for title in ("before", "after")]
    labels = ["a", "b", None, "a", "b"]
    figure = embedding_chart([panels, panels], labels, names=list("vwxyz"), path=True)
    assert len(figure.axes) == 4
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["no label", "a", "b"]
    assert figure.axes[0].get_xlabel() == "first component (70%)"
    for axes, panel in zip(figure.axes, [*panels, *panels], strict=True):
        drawn = np.concatenate([np.asarray(points.get_offsets()) for points in axes.collections])
        assert {tuple(point) for point in drawn} == {tuple(point) for point in panel.points}


def test_no_group_of_many_lies_on_top_of_another():
    n = 4000
    labels = [None] * 1000 + ["a"] * 1500 + ["b"] * 1500
    points = np.stack([np.arange(n), np.zeros(n)], axis=1)
    figure = embedding_chart([[Panel(points, [1, 0], "")]], labels)
    drawn = figure.axes[0].collections[-1]
    order = drawn.get_offsets()[:, 0].astype(int)
    assert sorted(order) == list(range(n))
    assert set(order[:1000]) == set(range(1000))  # no label: below all
    assert 600 < sum(labels[i] == "a" for i in order[-1500:]) < 900
    assert drawn.get_sizes() == [5]


def test_colours_go_by_first_appearance():
    assert label_colours(["b", "a", "b"]) == {"b": "C0", "a": "C1"}
    assert list(label_colours(["a", None])) == [None, "a"]
    assert embedding_chart([[Panel(np.eye(2), [1, 0], "")]], [None, None]).legends == []


def test_legend_and_names_stay_in_the_picture_and_off_one_another():
    turns = np.linspace(0, 4 * np.pi, 24)
    points = np.stack([np.cos(turns), np.sin(turns)], axis=1) + np.random.default_rng(0).normal(0, 0.03, (24, 2))
    labels = [f"a_rather_long_label_{i % 8}" for i in range(24)]
    figure = embedding_chart([[Panel(points, [1, 0], "")]], labels, names=[f"frame_{i:02d}" for i in range(24)])
    figure.draw_without_rendering()
    whole, frame = figure.bbox, figure.axes[0].get_window_extent()
    legend = figure.legends[0].get_window_extent()
    assert whole.x0 <= legend.x0
    assert legend.x1 <= whole.x1
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(boxes) > 15
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_a_unit_stands_beside_the_colour_bar(meshes):
    field = Field.positive(
        "where", "where", [np.abs(mesh.vertices[:, 0]) for mesh in meshes[:1]], unit="part of the area"
    )
    figure = highlight_chart(meshes[:1], ["a"], [field])
    assert "part of the area" in [axes.get_ylabel() for axes in figure.axes]
