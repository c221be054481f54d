"""The notebook of docs/ runs as it stands, in a kernel of its own, and shows pictures; Hydra plays no part."""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from lssd_learn import jupyter
from lssd_learn.collections import as_collection
from lssd_learn.latent import LatentSpace, MapNetwork

NOTEBOOK = Path(__file__).parents[1] / "docs" / "notebook.ipynb"
SMALL = ("collection=bodies_small", "collection.n=40", "basis.k=40", "latent.size=24", "latent.keep=20")
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def ran(pieces_of, tmp_path_factory, common_cache):
    """The notebook with its outputs, run where a small net has just been trained."""
    folder = tmp_path_factory.mktemp("notebook")
    pieces = pieces_of(folder, *SMALL, "task.epochs=2", f"cache={common_cache}")
    pieces.task(pieces, folder)
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    check = "import sys; print(sorted({'hydra', 'omegaconf'} & set(sys.modules)), lssd.__version__)"
    notebook.cells.append(nbformat.v4.new_code_cell(check, id="check"))
    path = os.pathsep.join([str(NOTEBOOK.parents[1]), os.environ.get("PYTHONPATH", "")])
    env = os.environ | {"LSSD_CACHE": str(common_cache), "PYTHONPATH": path}
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}})
    client.execute(env=env)
    return notebook


def outputs(notebook, kind):
    """Of every cell that has one, by the first line of the cell's text."""
    found = {}
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            if kind in output.get("data", {}):
                found[cell.source.splitlines()[-1]] = output["data"][kind]
    return found


def test_shapes_collections_and_spaces_are_shown_as_pictures(ran):
    pictures = outputs(ran, "image/png")
    assert {"bodies", "lssd_of.latent_", "new[0]"} <= pictures.keys()
    assert any(last.startswith("Image") for last in pictures)


def test_and_told_in_a_line(ran):
    told = outputs(ran, "text/plain")
    assert told["bodies"] == "Bodies(40 shapes: body_0000, body_0001, …, body_0039)"
    assert told["lssd_of.latent_"] == "LatentSpace(40 shapes of 40 functions, size=32, keep=20)"
    assert told["model"] == "Trained(regression of 12 parameters, CNN on area operators)"
    assert told["new[0]"].startswith("Mesh(615 vertices")


def test_hydra_is_not_imported(ran):
    assert ran.cells[-1].outputs[0].text.startswith("[] ")


def test_a_picture_is_a_png(meshes, truncated):
    assert jupyter.shape_png(meshes[0]).startswith(PNG)
    assert jupyter.collection_png(as_collection(meshes)).startswith(PNG)
    assert jupyter.collection_png(as_collection([])) is None
    assert jupyter.latent_png(LatentSpace.fit(MapNetwork.clique(truncated(5, 20)), 12, 8)).startswith(PNG)
