import numpy as np
import pytest
import trimesh
from PIL import Image

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.view.painter import MARGIN, paint, save_png


def sphere(centre=(0, 0, 0), radius=1.0, subdivisions=4):
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(ball.vertices + np.array(centre), ball.faces)


def joined(*meshes):
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def silhouette(image):
    return (image < 255).any(axis=2)


def test_a_ball_on_white():
    image = paint(sphere(), size=300)
    assert (image.shape, image.dtype) == ((300, 300, 3), np.uint8)
    radius = 300 * (1 - 2 * MARGIN) / 2
    assert silhouette(image).sum() == pytest.approx(np.pi * radius**2, rel=0.02)
    assert (image[[0, -1]] == 255).all()
    assert (image[:, [0, -1]] == 255).all()
    assert (image[150, 150] < 255).any()


def test_outlines_are_smoothed():
    shade = paint(sphere(), size=100).astype(int).sum(axis=2)
    assert len(np.unique(shade[50, :20])) > 3


def test_shading_is_smooth_across_faces():
    coarse, fine = (paint(sphere(subdivisions=s), size=200).astype(float) for s in (3, 5))
    inner = np.hypot(*(np.mgrid[:200, :200] - 99.5)) < 80
    assert abs(coarse - fine)[inner].max() < 4


def coloured(azimuth, up="z"):
    """The colours of a ball at -y (value 0, dark) before one at +y (value 1, bright), from some side."""
    small, large = sphere((0, -3, 0), 0.5), sphere((0, 3, 0), 1.0)
    both = joined(small, large)
    if up == "y":
        both = Mesh(both.vertices[:, [0, 2, 1]] * [1, 1, -1], both.faces)
    values = np.repeat([0.0, 1.0], [len(small.vertices), len(large.vertices)])
    return paint(both, values, azimuth=azimuth, elevation=0, size=200, colormap="gray", up=up)


@pytest.mark.parametrize("up", ["z", "y"])
def test_the_nearer_ball_hides_the_farther(up):
    front, back = coloured(0, up), coloured(180, up)
    middle = front.shape[0] // 2, front.shape[1] // 2
    assert front[middle].max() < 10
    assert back[middle].min() > 100


def test_from_the_left_the_front_is_on_the_left():
    side = coloured(90)
    row = side[side.shape[0] // 2].astype(int).sum(axis=1)
    seen = np.flatnonzero(row < 3 * 255)
    assert row[seen[: len(seen) // 4]].min() < 30
    assert row[seen[-1] - 20] > 300


def test_from_above():
    high, low = sphere((0, 0, 2), 0.5), sphere((0, 0, -2))
    values = np.repeat([0.0, 1.0], [len(high.vertices), len(low.vertices)])
    image = paint(joined(high, low), values, elevation=90, size=100, colormap="gray")
    assert image[50, 50].max() < 10


def test_several_shapes_share_one_scale():
    image = paint([sphere(), sphere(radius=0.5), PointCloud(sphere().vertices)], size=200)
    assert image.shape == (200, 600, 3)
    large, small, cloud = (silhouette(cell).sum() for cell in np.split(image, 3, axis=1))
    assert large / small == pytest.approx(4, rel=0.05)
    assert 0.9 * large < cloud < 1.2 * large


def test_the_space_fits_the_shapes():
    tall = Mesh(sphere().vertices * [0.2, 0.2, 1], sphere().faces)
    height, width, _ = paint([tall, tall], size=200).shape
    assert height == 200
    assert 2 * 40 < width < 2 * 80


def test_values_of_both_signs_are_blue_and_red():
    ball = sphere()
    image = paint(ball, ball.vertices[:, 2], size=100, elevation=0).astype(int)
    above, below = image[20, 50], image[80, 50]
    assert above[0] > above[2] + 50
    assert below[2] > below[0] + 50


def test_limits_are_shared_and_can_be_given():
    ball, ones = sphere(), np.ones(len(sphere().vertices))
    both = paint([ball, ball], [0 * ones, ones], size=60)
    np.testing.assert_array_equal(both[:, :60], paint(ball, 0 * ones, size=60, limits=(0, 1)))
    np.testing.assert_array_equal(both[:, 60:], paint(ball, 7 * ones, size=60, limits=(0, 1)))
    np.testing.assert_array_equal(paint([ball, ball], [None, ones], size=60)[:, :60], paint(ball, size=60))


def test_the_inside_of_an_open_mesh_is_lit():
    ball = sphere()
    bowl = Mesh(ball.vertices, ball.faces[ball.vertices[ball.faces][..., 1].max(axis=1) > 0])  # its mouth towards us
    image = paint(bowl, size=100, azimuth=0, elevation=0)
    assert image[50, 50].min() > 60


def test_a_single_point():
    image = paint(PointCloud(np.zeros((1, 3))), size=100)
    assert 0 < silhouette(image).sum() < 40


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shapes": []}, r"shapes: expected at least one to paint"),
        ({"values": np.ones(3)}, r"values: expected 162 finite numbers for shape 0, got \(3,\)"),
        ({"values": np.full(162, np.nan)}, r"values: expected 162 finite numbers for shape 0"),
        (
            {"shapes": [sphere(subdivisions=2)], "values": []},
            r"values: expected one function for each of 1 shapes, got 0",
        ),
        ({"up": "x"}, r"up: expected 'y' or 'z', got 'x'"),
        ({"colormap": "mud"}, r"colormap: expected one that matplotlib knows.*got 'mud'"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        paint(**{"shapes": sphere(subdivisions=2)} | arguments)


def test_png(tmp_path):
    image = paint(sphere(), size=50)
    save_png(image, tmp_path / "ball.png")
    with Image.open(tmp_path / "ball.png") as read:
        np.testing.assert_array_equal(np.asarray(read), image)
    with pytest.raises(InputError, match=r"nowhere does not exist"):
        save_png(image, tmp_path / "nowhere" / "ball.png")
