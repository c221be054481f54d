"""Without the body model a generated body says in one line what to install; nothing else asks for it."""

import subprocess
import sys
from importlib import metadata

import pytest

from lssd_learn.collections import Bodies, Faces, Folder
from lssd_learn.collections.generated.body import package as body_package
from lssd_learn.errors import InputError


@pytest.fixture
def _without(monkeypatch):
    def version(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(body_package, "version", version)


@pytest.mark.usefixtures("_without")
@pytest.mark.parametrize("kind", [Bodies, Faces])
def test_it_says_what_to_install(kind):
    with pytest.raises(InputError, match=r"^collection: generated bodies .*: pip install 'lssd_learn\[bodies\]'"):
        _ = kind().key


@pytest.mark.usefixtures("_without")
def test_a_folder_does_not_ask(small_mesh_folder):
    assert len(Folder(small_mesh_folder)) == 5


def test_provenance_does_without(monkeypatch):
    from lssd_learn import app

    assert app._version("numpy") == metadata.version("numpy")
    assert app._version("no-such-package") is None


def test_importing_every_room_asks_for_no_body_model():
    code = (
        "import sys; sys.modules['anny'] = None; import lssd_learn as l;"
        "[getattr(l, name) for name in l.__all__]; import lssd_learn.app"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
