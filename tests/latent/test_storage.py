"""A latent space on disk."""

import io
import os
from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.cache import Cache
from lssd_learn.collections.base import ShapeList
from lssd_learn.collections.eigenbases import StoredBases, eigenbases
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, storage

TENSORS = ("Y", "evals", "spectrum", "U", "energy")


@pytest.fixture
def latent(truncated):
    return LatentSpace.fit(MapNetwork.clique(truncated(4, 12)), 10, 6, names=["a", "b", "ü", "d"])


@pytest.fixture
def stored(deformed_spheres, tmp_path):
    """A latent space whose eigenbases lie in a cache, and that cache."""
    collection = ShapeList(deformed_spheres(3, 1))
    collection.key = "spheres"
    cache = Cache(tmp_path / "cache")
    found = eigenbases(collection, 10, cache=cache)
    bases = StoredBases(cache, found.keys, found.names, "lssd collection=spheres")
    return LatentSpace.fit(MapNetwork.clique(bases), 8, 5, names=found.names), cache


def same(a, b):
    for name in TENSORS:
        assert torch.equal(getattr(a, name), getattr(b, name)), name
        assert getattr(b, name).dtype == torch.float64
    assert a.names == b.names


def test_what_was_saved_is_what_is_loaded(latent, tmp_path):
    path = latent.save(tmp_path / "new" / "space.npz")
    assert path == tmp_path / "new" / "space.npz"
    again = LatentSpace.load(path)
    same(latent, again)
    torch.testing.assert_close(again.differences()[1], latent.differences()[1])
    assert [p.name for p in path.parent.iterdir()] == ["space.npz"]
    with pytest.raises(InputError, match="loaded without its eigenbases"):
        again.to_shape(torch.ones(6), 0)


def test_with_bases_nothing_else_is_needed(latent, tmp_path):
    again = LatentSpace.load(latent.save(tmp_path / "space.npz", bases=True))
    same(latent, again)
    for ours, theirs in zip(latent.bases, again.bases, strict=True):
        for name in ("evals", "evecs", "mass"):
            np.testing.assert_array_equal(getattr(theirs, name), getattr(ours, name))
        assert theirs.connectivity == ours.connectivity
    alpha = np.arange(6.0)
    assert torch.equal(again.to_shape(alpha, 2), latent.to_shape(alpha, 2))


def test_a_point_cloud_has_no_connectivity_after_loading_either(latent, tmp_path):
    clouds = replace(latent, bases=[replace(basis, connectivity=None) for basis in latent.bases])
    assert LatentSpace.load(clouds.save(tmp_path / "space", bases=True)).bases[0].connectivity is None


def test_the_suffix_is_added_and_takes_nothing_away(latent, tmp_path):
    assert latent.save(tmp_path / "space").name == "space.npz"
    assert latent.save(tmp_path / "keep_0.5").name == "keep_0.5.npz"


def test_eigenbases_are_found_again_in_the_cache(stored, tmp_path):
    latent, cache = stored
    path = latent.save(tmp_path / "space.npz")
    assert path.stat().st_size < 20_000
    again = LatentSpace.load(path, cache)
    same(latent, again)
    assert torch.equal(again.to_shape(np.ones(5), 1), latent.to_shape(np.ones(5), 1))
    assert again.bases[1].connectivity == latent.bases[1].connectivity


def test_a_missing_eigenbasis_names_the_command_that_makes_it_again(stored, tmp_path):
    latent, _ = stored
    again = LatentSpace.load(latent.save(tmp_path / "space.npz"), Cache(tmp_path / "elsewhere"))
    assert again.differences()[0].shape == (3, 5, 5)  # needs no eigenbasis
    with pytest.raises(
        InputError, match="eigenbasis of 1: .*elsewhere.* is missing; make it again with: lssd collection=spheres"
    ):
        again.to_shape(np.ones(5), 1)


def test_a_space_saved_with_bases_needs_no_cache(stored, tmp_path):
    latent, _ = stored
    again = LatentSpace.load(latent.save(tmp_path / "space.npz", bases=True), Cache(tmp_path / "elsewhere"))
    assert torch.equal(again.to_shape(np.ones(5), 1), latent.to_shape(np.ones(5), 1))


def test_a_state_goes_through_a_checkpoint(stored, tmp_path):
    latent, cache = stored
    torch.save(storage.to_state(latent), tmp_path / "last.ckpt")
    state = torch.load(tmp_path / "last.ckpt", weights_only=True)
    again = storage.from_state(LatentSpace, state, cache)
    same(latent, again)
    assert torch.equal(again.to_shape(np.ones(5), 1), latent.to_shape(np.ones(5), 1))
    with pytest.raises(InputError, match="latent space: expected format 1, got 7"):
        storage.from_state(LatentSpace, state | {"version": 7})


def test_a_checkpoint_holds_the_space_it_was_trained_in(stored, tmp_path):
    latent, cache = stored
    torch.save({"latent": latent.state(), "state_dict": {}}, tmp_path / "best.ckpt")
    again = LatentSpace.load(tmp_path / "best.ckpt", cache)
    same(latent, again)
    assert torch.equal(again.to_shape(np.ones(5), 1), latent.to_shape(np.ones(5), 1))
    torch.save({"state_dict": {}}, tmp_path / "clouds.ckpt")
    (tmp_path / "text.ckpt").write_text("hello")
    (tmp_path / "empty.ckpt").write_text("")
    for name, message in (
        ("clouds", "expected a checkpoint trained on operators, but it holds no latent space"),
        ("text", "expected a checkpoint, but it cannot be read"),
        ("empty", "expected a checkpoint, but it cannot be read"),
        ("nowhere", "no such file; expected a checkpoint"),
    ):
        with pytest.raises(InputError, match=f"{name}.ckpt: {message}"):
            LatentSpace.load(tmp_path / f"{name}.ckpt")


def archive(**arrays):
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def array():
    stream = io.BytesIO()
    np.save(stream, np.ones(3))
    return stream.getvalue()


@pytest.mark.parametrize(
    "content",
    [b"", b"hello", archive(x=np.ones(3)), archive(Y=np.ones(3))[:60], array(), b"\x80\x04N."],
    ids=["empty", "text", "another archive", "cut off", "a bare array", "a pickle"],
)
def test_what_is_not_a_latent_space_is_refused(tmp_path, content):
    path = tmp_path / "space.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"space.npz: expected a saved latent space \(.npz\), but it cannot be read"):
        LatentSpace.load(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nowhere.npz: no such file; expected a saved latent space"):
        LatentSpace.load(tmp_path / "nowhere.npz")


def test_a_failed_save_leaves_the_old_file(latent, tmp_path, monkeypatch):
    path = latent.save(tmp_path / "space.npz")
    before = path.read_bytes()

    def fails(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez", fails)
    with pytest.raises(OSError, match="disk full"):
        latent.save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["space.npz"]


class Payload:
    """What pickle would make a folder of, were it let."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def test_code_in_a_checkpoint_is_refused_and_not_run(tmp_path):
    path, harm = tmp_path / "best.ckpt", tmp_path / "harm"
    torch.save({"state_dict": {}, "epoch": 1, "hyper_parameters": Payload(harm)}, path)
    with pytest.raises(InputError, match="best.ckpt: expected a checkpoint, but it cannot be read"):
        storage.read_checkpoint(path)
    assert not harm.exists()
    torch.load(path, weights_only=False)  # as any reader would that trusts the file
    assert harm.exists()
