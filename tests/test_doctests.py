"""Every function and class of the first page of the API has an example, and it runs."""

import doctest
import importlib
import inspect

import pytest

import lssd_learn
from lssd_learn.operators import analogy, interpolate

ON_A_PAGE = ("Pipeline",)  # its example stands in docs/reference/index.md, which tests/test_docs.py runs
PUBLIC = {name: getattr(lssd_learn, name) for name in lssd_learn._PUBLIC} | {
    "analogy": analogy,
    "interpolate": interpolate,
}


@pytest.mark.parametrize("name", [name for name in PUBLIC if name not in ON_A_PAGE])
def test_an_example_stands_in_the_docstring_and_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
    thing = PUBLIC[name]
    module = importlib.import_module(thing.__module__)
    found = doctest.DocTestFinder(recurse=False).find(inspect.unwrap(thing), name, module=False, globs={})
    examples = [test for test in found if test.examples]
    assert examples, f"{module.__name__}.{name}"
    for test in examples:
        told = []
        doctest.DocTestRunner(optionflags=doctest.ELLIPSIS, verbose=False).run(test, out=told.append)
        assert not told, "".join(told)
