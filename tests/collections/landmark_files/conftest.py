"""What tests of files of landmarks share."""

import pytest

from lssd_learn.collections.landmark_files.files import read_specimens


@pytest.fixture
def read(tmp_path):
    """A function: name, text or bytes → the specimens."""

    def write(name, text):
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_specimens(tmp_path / name)

    return write
