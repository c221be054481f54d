"""What a folder holds beside its shapes: nothing is passed over in silence."""

import numpy as np
import pytest

from lssd_learn.collections import Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import FORMATS, Mesh, save


@pytest.fixture
def folder(tmp_path):
    """Three tetrahedra in three formats."""
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    for name in ("a.off", "b.obj", "c.ply"):
        save(Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), faces), tmp_path / name)
    return tmp_path


def test_what_is_no_file_is_not_passed_over(folder):
    for place in ("d.ply", "labels.csv", "landmarks.csv"):
        (folder / place).mkdir()
        with pytest.raises(InputError, match=f"{place}: expected a file, it is a folder"):
            Folder(folder)
        (folder / place).rmdir()
    (folder / "d.ply").symlink_to(folder / "nowhere")
    with pytest.raises(InputError, match="d.ply: expected a file, it is a link to nothing"):
        Folder(folder)
    (folder / "d.ply").unlink()
    (folder / "maps").write_text("")
    with pytest.raises(InputError, match="maps: expected a folder of maps A__B.txt, it is a file"):
        Folder(folder)
    (folder / "maps").unlink()
    (folder / "maps").mkdir()
    (folder / "maps" / "readme.md").write_text("a note")
    (folder / "maps" / "a__b.csv").write_text("0")
    with pytest.raises(InputError, match="a__b.csv: expected a name A__B.txt"):
        Folder(folder)


@pytest.mark.parametrize("name", ["Labels.csv", "LABELS.CSV", "labels.TSV"])
def test_a_table_of_labels_in_any_case(folder, name):
    (folder / name).write_text("name,age\na,1\nb,2\nc,4\n")
    np.testing.assert_array_equal(Folder(folder).parameters, [[1], [2], [4]])
    (folder / "labels.tsv" if name == "Labels.csv" else folder / "Labels.csv").write_text("name\tage\n")
    with pytest.raises(InputError, match="expected one table of labels, got "):
        _ = Folder(folder).parameters


def test_files_of_other_kinds_are_told(folder, caplog):
    """Once, in one line, and without what stands beside shapes anyway."""
    for name in ("d.3ds", "e.3DS", "f.x3d", "scan.png", "README", "notes.md", "b.mtl", "settings.json", ".hidden.3ds"):
        (folder / name).write_text("")
    (folder / "old.3ds.d").mkdir()
    warnings = Folder(folder).check()
    told = [line for line in warnings if "not read" in line]
    assert told == [f"{folder.name}: not read: 2 .3ds, 1 .x3d (shapes are {' '.join(FORMATS)})"]
    assert told[0] in caplog.messages
    for file in folder.glob("[abc].*"):
        file.unlink()
    with pytest.raises(InputError, match=r"expected shapes \(.*\), found 2 .3ds, 1 .x3d"):
        Folder(folder)
