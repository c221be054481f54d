"""`data.augment` through the configuration."""

import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import save

SMALL = ("collection=folder", "basis.k=10", "latent.size=8", "latent.keep=6", "data.points=64", "task.epochs=2")


@pytest.fixture
def train(pieces_of, deformed_spheres, tmp_path, monkeypatch):
    """A function of overrides → metrics of a regression on twelve spheres."""
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "shapes"
    folder.mkdir()
    for i, mesh in enumerate(deformed_spheres(12, 1)):
        save(mesh, folder / f"s{i:02d}.ply")
    rows = [f"s{i:02d},{i / 12}\n" for i in range(12)]
    (folder / "labels.csv").write_text("name,size\n" + "".join(rows))

    def run(*overrides):
        pieces = pieces_of(
            tmp_path, *SMALL, f"collection.path={folder}", *overrides, net=overrides[0].removeprefix("net=")
        )
        metrics = pieces.task(pieces, tmp_path)
        return {name: value for name, value in metrics.items() if not name.startswith("seconds")}

    return run


@pytest.mark.slow
def test_every_augmentation_trains_another_net(train):
    results = [train("net=pointnet", "collection.up=y")]
    for augment in ("turn", "resample", "both"):
        results.append(train("net=pointnet", "collection.up=y", f"data.augment={augment}"))
        assert results[-1] not in results[:-1]
    assert train("net=pointnet", "data.augment=none") == results[0]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("net=pointnet", "data.augment=turns"), "data.augment=turns: expected one of none, turn, resample, both"),
        (("net=mlp", "data.augment=both"), "data.augment=both: expected a net on clouds; net=mlp reads operators"),
        (("net=pointnet", "data.augment=turn"), "data.augment=turn: expected to know which axis is up; collection.up="),
    ],
)
def test_augmentations_are_refused_before_any_work(train, tmp_path, overrides, message):
    with pytest.raises(InputError, match=message):
        train(*overrides)
    assert not (tmp_path / "cache" / "eigenbasis").exists()
