import json
import logging
import multiprocessing

import pytest

from lssd_learn.collections.generated.body import cache as body_cache
from lssd_learn.collections.generated.body.cache import guarded, is_intact
from lssd_learn.errors import InputError


def safetensors(payload=b"12345678"):
    header = json.dumps(
        {"__metadata__": {"a": "b"}, "x": {"dtype": "U8", "shape": [8], "data_offsets": [0, len(payload)]}}
    ).encode()
    return len(header).to_bytes(8, "little") + header + payload


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "v14").mkdir()
    (tmp_path / "v14" / "good.safetensors").write_bytes(safetensors())
    return tmp_path


def built(folder):
    return sorted(file.name for file in folder.glob("v*/*.safetensors"))


def leftovers(folder):
    return [path.name for path in folder.iterdir() if path.name.startswith(body_cache.STAGING)]


def test_the_same_bytes_that_the_library_writes(tmp_path):
    import numpy as np
    from safetensors.numpy import save_file

    save_file({"a": np.zeros(3), "b": np.ones((2, 2), np.float32)}, tmp_path / "x.safetensors")
    assert is_intact(tmp_path / "x.safetensors")


@pytest.mark.parametrize("length", [0, 5, 8, 30, -1])
def test_a_truncated_file_is_noticed(tmp_path, length):
    file = tmp_path / "x"
    file.write_bytes(safetensors())
    assert is_intact(file)
    file.write_bytes(safetensors()[:length])
    assert not is_intact(file)


@pytest.mark.parametrize("content", [b"\x02" + bytes(7) + b"[]", b"\x08" + bytes(7) + b'{"a": 1}', bytes(100)])
def test_what_is_no_safetensors_file_is_noticed(tmp_path, content):
    (tmp_path / "x").write_bytes(content)
    assert not is_intact(tmp_path / "x")


def test_damaged_files_are_removed_and_said(folder, caplog):
    (folder / "v14" / "bad.safetensors").write_bytes(safetensors()[:-1])
    with caplog.at_level(logging.WARNING), guarded(folder) as staging:
        assert built(staging) == ["good.safetensors"]
    assert built(folder) == ["good.safetensors"]
    assert "bad.safetensors is damaged" in caplog.text


def test_new_files_are_moved_and_staging_is_removed(folder):
    with guarded(folder) as staging:
        assert (staging / "v14" / "good.safetensors").stat().st_ino == (
            folder / "v14" / "good.safetensors"
        ).stat().st_ino
        (staging / "v14" / "new.safetensors").write_bytes(safetensors())
        (staging / "v15").mkdir()
        (staging / "v15" / "newer.safetensors").write_bytes(safetensors())
        assert built(folder) == ["good.safetensors"]
    assert built(folder) == ["good.safetensors", "new.safetensors", "newer.safetensors"]
    assert leftovers(folder) == []


def test_a_failed_build_leaves_nothing(folder):
    def fail():
        with guarded(folder) as staging:
            (staging / "v14" / "half.safetensors").write_bytes(safetensors()[:-1])
            raise RuntimeError("killed")

    with pytest.raises(RuntimeError, match="killed"):
        fail()
    assert built(folder) == ["good.safetensors"]
    assert leftovers(folder) == []
    with guarded(folder):  # the lock was given back
        pass


def test_what_a_killed_run_left_is_removed(folder):
    stale = folder / f"{body_cache.STAGING}dead" / "v14"
    stale.mkdir(parents=True)
    (stale / "half.safetensors").write_bytes(b"half")
    with guarded(folder) as staging:
        assert leftovers(folder) == [staging.name]
    assert leftovers(folder) == []


def test_copies_where_there_are_no_links(folder, monkeypatch):
    def refuse(*_):
        raise OSError

    monkeypatch.setattr(body_cache.os, "link", refuse)
    with guarded(folder) as staging:
        assert (staging / "v14" / "good.safetensors").read_bytes() == safetensors()


def hold(folder, events, name):
    with guarded(folder):
        events.put(f"{name} in")
        events.put(f"{name} out")


def test_one_process_at_a_time(folder):
    context = multiprocessing.get_context("spawn")
    events = context.Queue()
    with guarded(folder):
        processes = [context.Process(target=hold, args=(folder, events, name)) for name in "ab"]
        for process in processes:
            process.start()
        for process in processes:
            process.join(0.3)
        assert events.empty()
    order = [events.get(timeout=30) for _ in range(4)]
    for process in processes:
        process.join()
    assert order[0][0] == order[1][0] != order[2][0] == order[3][0]


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written .*set ANNY_CACHE_DIR"), guarded(tmp_path / "file"):
        pass
