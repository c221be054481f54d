"""What may be installed: nothing with a known hole."""

import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
REQUIREMENTS = [
    Requirement(line)
    for lines in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values())
    for line in lines
    if not line.startswith("lssd_learn[")  # an extra that takes in another
]

# The last release that each advisory is about.
KNOWN_BAD = [
    ("lightning", "2.6.2", "a compromised release"),
    ("lightning", "2.6.3", "a compromised release"),
    ("lightning", "2.3.2", "CVE-2024-5452: code run from a request"),
    ("torch", "2.5.1", "CVE-2025-32434: weights_only runs code"),
    ("joblib", "1.1.1", "CVE-2022-21797: pre_dispatch runs code"),
    ("scipy", "1.9.3", "CVE-2023-25399: memory leak"),
    ("pyyaml", "5.3.1", "CVE-2020-14343: full_load runs code"),
    ("distributed", "2025.12.0", "CVE-2026-23528: code run through the dashboard"),
    ("ray", "2.51.2", "CVE-2025-62593: code run through a browser"),
]


@pytest.mark.parametrize(("name", "release", "why"), KNOWN_BAD)
def test_a_release_with_a_known_hole_is_never_installed(name, release, why):
    bounds = [requirement.specifier for requirement in REQUIREMENTS if requirement.name == name]
    assert bounds, f"{name} is not asked for any more: drop the line"
    assert not any(bound.contains(release) for bound in bounds), why


def test_every_dependency_has_a_lower_bound():
    for requirement in REQUIREMENTS:
        assert any(bound.operator == ">=" for bound in requirement.specifier)
