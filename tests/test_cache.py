"""The store of arrays: an entry is whole or not there, and changes with everything that it depends on."""

import json
import logging
import os
import pickle
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.cache import store as cache_module
from lssd_learn.cache.packed import MAPPED
from lssd_learn.errors import InputError


class Counted:
    """A `make` that counts its calls."""

    def __init__(self, **arrays):
        self.arrays, self.calls = arrays, 0

    def __call__(self):
        self.calls += 1
        return self.arrays


def never():
    raise AssertionError("made again")


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


@given(a=st.lists(plain, max_size=3), b=st.lists(plain, max_size=3))
@settings(max_examples=200, deadline=None)
def test_a_fingerprint_tells_everything_apart(a, b):
    # JSON is what the values are compared as: 1 and 1.0 and True are three things.
    same = json.dumps(a, sort_keys=True) == json.dumps(b, sort_keys=True)
    assert (fingerprint(*a) == fingerprint(*b)) == same
    assert len(fingerprint(*a)) == 32
    assert set(fingerprint(*a)) <= set("0123456789abcdef")


def test_a_fingerprint_is_sensitive_to_order_and_nesting_but_not_to_the_order_of_keys():
    different = [(1, 2), (2, 1), ([1, 2],), (1, [2]), ("12",), ("1", "2"), (12,), (1, 2, None), (1.0, 2), (True, 2)]
    assert len({fingerprint(*parts) for parts in different}) == len(different)
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})


@pytest.mark.parametrize("part", [float("nan"), float("inf"), np.float32(1), object(), {1, 2}])
def test_what_has_no_plain_words_has_no_fingerprint(part):
    with pytest.raises((TypeError, ValueError)):
        fingerprint("a", part)


@given(
    array=npst.arrays(
        st.one_of(
            npst.boolean_dtypes(),
            npst.integer_dtypes(),
            npst.floating_dtypes(sizes=(16, 32, 64)),
            npst.complex_number_dtypes(sizes=(64, 128)),
            npst.unicode_string_dtypes(max_len=4),
        ),
        npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
    fortran=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_arrays_come_back_as_they_were(tmp_path_factory, array, fortran):
    cache = Cache(tmp_path_factory.mktemp("cache"))
    given_ = np.asfortranarray(array) if fortran and array.ndim else array
    for found in (cache.get("s", "k", lambda: {"x": given_}), Cache(cache.root).load("s", "k")):
        assert list(found) == ["x"]
        assert found["x"].dtype == array.dtype
        assert found["x"].shape == array.shape
        np.testing.assert_array_equal(found["x"], array)


def test_views_and_scalars_are_stored_as_arrays(cache):
    found = cache.get("s", "k", lambda: {"view": np.arange(10)[::3], "number": np.float64(2), "text": np.array("abc")})
    assert found["view"].tolist() == [0, 3, 6, 9]
    assert found["number"].shape == ()
    assert str(found["text"]) == "abc"


def test_large_arrays_are_mapped_and_all_are_read_only(cache):
    found = cache.get("s", "k", lambda: {"small": np.ones(3), "large": np.ones(MAPPED // 8)})
    assert [isinstance(found[name], np.memmap) for name in ("small", "large")] == [False, True]
    for array in found.values():
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 2


def test_what_is_there_is_not_made_again(cache):
    make = Counted(x=np.arange(3))
    for which in (cache, cache, Cache(cache.root)):
        assert which.get("s", "k", make)["x"].tolist() == [0, 1, 2]
    assert make.calls == 1
    assert cache.load("s", "other") is None
    assert cache.load("other", "k") is None


def test_stages_and_keys_do_not_meet(cache):
    for stage in "ab":
        for key in "xy":
            cache.get(stage, key, lambda text=stage + key: {"text": np.array(text)})
    assert [str(cache.get(s, k, never)["text"]) for s in "ab" for k in "xy"] == ["ax", "ay", "bx", "by"]


def flip(file, place):
    content = bytearray(file.read_bytes())
    content[place] ^= 1
    file.write_bytes(content)


@pytest.mark.parametrize("place", [3, 300, 799, 810, -20, -1])
def test_a_flipped_bit_is_noticed_and_the_entry_made_again(cache, caplog, place):
    make = Counted(x=np.arange(100), y=np.ones(5))
    cache.get("s", "k", make)
    flip(cache.path("s", "k"), place)
    fresh = Cache(cache.root)
    with caplog.at_level(logging.WARNING):
        found = fresh.get("s", "k", make)
    assert found["x"].tolist() == list(range(100))
    if place == 810:  # between the arrays there is nothing
        assert make.calls == 1
        return
    assert make.calls == 2
    assert "cache entry s/k is damaged (" in caplog.text
    assert Cache(cache.root).get("s", "k", never)["y"].tolist() == [1] * 5


def test_a_flipped_bit_of_a_large_array_is_noticed(cache, caplog):
    cache.get("s", "k", lambda: {"small": np.ones(3), "large": np.ones(MAPPED // 8)})
    flip(cache.path("s", "k"), MAPPED // 2)
    with caplog.at_level(logging.WARNING):
        assert Cache(cache.root).load("s", "k") is None
    assert "(large has a wrong checksum)" in caplog.text


@given(cut=st.floats(0, 1, exclude_max=True))
@settings(max_examples=25, deadline=None)
def test_a_file_cut_off_anywhere_is_no_entry_and_is_made_again(tmp_path_factory, cut):
    cache, make = Cache(tmp_path_factory.mktemp("cache")), Counted(x=np.arange(9), y=np.ones(2))
    cache.get("s", "k", make)
    file = cache.path("s", "k")
    content = file.read_bytes()
    file.write_bytes(content[: int(cut * len(content))])
    fresh = Cache(cache.root)
    assert fresh.load("s", "k") is None
    assert fresh.get("s", "k", make)["x"].tolist() == list(range(9))
    assert Cache(cache.root).get("s", "k", never)["y"].tolist() == [1, 1]


def test_an_entry_is_one_file_and_folders_stay_small(cache):
    keys = [fingerprint(i) for i in range(300)]
    for key in keys:
        cache.get("s", key, lambda: {"x": np.ones(3), "y": np.ones(2)})
    folders = list((cache.root / "s").iterdir())
    assert max(len(list(folder.iterdir())) for folder in folders) < 10
    assert sorted(file.stem for folder in folders for file in folder.iterdir()) == sorted(keys)


@pytest.fixture
def before(cache):
    """An entry as earlier versions wrote it."""
    folder = cache.root / "s" / fingerprint("k")
    folder.mkdir(parents=True)
    arrays = {"x": np.arange(100), "large": np.ones(MAPPED // 8), "text": np.array("abc")}
    manifest = {"arrays": {}}
    for name, array in arrays.items():
        np.save(folder / f"{name}.npy", array)
        content = (folder / f"{name}.npy").read_bytes()
        manifest["arrays"][name] = {"bytes": len(content), "crc32": zlib.crc32(content)}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def test_an_entry_of_earlier_versions_is_read(cache, before):
    found = cache.get("s", before.name, never)
    assert found["x"].tolist() == list(range(100))
    assert isinstance(found["large"], np.memmap)
    assert str(found["text"]) == "abc"


@pytest.mark.parametrize("damage", ["bit", "no file", "names"])
def test_one_that_is_damaged_is_made_again(cache, caplog, before, damage):
    match damage:
        case "bit":
            flip(before / "x.npy", -1)
        case "no file":
            (before / "x.npy").unlink()
        case "names":
            (before / "manifest.json").write_text((before / "manifest.json").read_text().replace("crc32", "crc33"))
    make = Counted(x=np.arange(3))
    with caplog.at_level(logging.WARNING):
        assert cache.get("s", before.name, make)["x"].tolist() == [0, 1, 2]
    assert "is damaged" in caplog.text
    assert cache.get("s", before.name, never)["x"].tolist() == [0, 1, 2]


def test_a_make_that_fails_leaves_nothing(cache):
    def fails():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        cache.get("s", "k", fails)
    for wrong in (np.array([object()]), np.zeros(2, [("a", int), ("b", float)])):
        with pytest.raises(ValueError, match="y: expected an array of numbers, truth values or texts"):
            cache.get("s", "k", lambda wrong=wrong: {"x": np.ones(3), "y": wrong})
    assert cache.load("s", "k") is None
    assert not [p for p in (cache.root / "s" / "k").iterdir() if p.suffix != ".lock"]
    assert cache.get("s", "k", lambda: {"x": np.ones(3)})["x"].tolist() == [1, 1, 1]


def test_an_error_of_reading_while_making_is_not_blamed_on_the_cache(cache):
    with pytest.raises(FileNotFoundError, match="missing_mesh"):
        cache.get("s", "k", lambda: {"x": np.frombuffer(Path("missing_mesh.ply").read_bytes())})


def test_damage_is_told_once(cache, caplog):
    cache.get("s", "k", lambda: {"x": np.arange(100)})
    flip(cache.path("s", "k"), 5)
    fresh = Cache(cache.root)
    with caplog.at_level(logging.WARNING):
        fresh.load("s", "k")
        pickle.loads(pickle.dumps(fresh)).get("s", "k", lambda: {"x": np.arange(100)})
    assert len(caplog.messages) == 1


def test_a_folder_that_cannot_be_written_is_an_input_error(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match=r"cache .*file: cannot write stage 's': (Not a directory|File exists)"):
        Cache(tmp_path / "file").get("s", "k", never)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_an_input_error(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot write stage 's': Permission denied"):
        Cache(tmp_path / "cache").get("s", "k", never)


def test_the_environment_wins(tmp_path, monkeypatch):
    asked, wins = tmp_path / "asked", tmp_path / "wins"
    monkeypatch.setenv("LSSD_CACHE", str(wins))
    cache = Cache(asked)
    cache.get("s", "k", lambda: {"x": np.ones(1)})
    assert cache.path("s", "k") == wins / "s" / "k" / "k.arrays"
    assert cache.path("s", "k").exists()
    assert not asked.exists()
    monkeypatch.setenv("LSSD_CACHE", "")
    assert Cache(asked).root == asked


def test_the_place_is_absolute_and_a_home_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert Cache("data/cache").root == tmp_path / "data" / "cache"
    assert Cache("~/x").root == tmp_path / "home" / "x"
    assert not (tmp_path / "data").exists()  # made when the first entry is written


def test_a_checkout_keeps_its_own_and_an_installed_package_uses_the_users(tmp_path, monkeypatch):
    monkeypatch.delenv("LSSD_CACHE", raising=False)
    assert Cache().root == Path(cache_module.__file__).parents[2] / "data" / "cache"
    monkeypatch.setattr(cache_module, "__file__", str(tmp_path / "site-packages" / "lssd_learn" / "cache" / "store.py"))
    monkeypatch.setattr(cache_module, "user_cache_path", lambda name, author: tmp_path / "user" / name)
    assert Cache().root == tmp_path / "user" / "lssd_learn"
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "asked"))
    assert Cache().root == tmp_path / "asked"


def test_a_cache_goes_to_workers_and_verifies_again(cache):
    cache.get("s", "k", lambda: {"x": np.arange(50)})
    flip(cache.path("s", "k"), 5)
    assert cache.load("s", "k") is not None  # verified before
    assert pickle.loads(pickle.dumps(cache)).load("s", "k") is None
