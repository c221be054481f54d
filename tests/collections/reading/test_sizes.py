"""Which sizes are another unit, and which only another animal."""

import numpy as np
import pytest

from lssd_learn.collections import Folder
from lssd_learn.collections.reading.sizes import odd_sizes
from lssd_learn.shapes import Mesh, save

NAMES = [f"s{i}" for i in range(8)]
ALIKE = np.array([1.0, 1.1, 0.95, 1.05, 0.9, 1.02, 1.07, 0.98])


@pytest.mark.parametrize(
    ("factor", "guess"),
    [
        (1000, "in mm, the others in m"),
        (0.001, "in m, the others in mm"),
        (100, "in cm, the others in m"),
        (10, "in mm, the others in cm"),
        (1 / 25.4, "in inches, the others in mm"),
        (2.54, "in cm, the others in inches"),
        (39.4, "in inches, the others in m"),
    ],
)
def test_one_in_another_unit_is_named_with_the_factor(factor, guess):
    sizes = ALIKE.copy()
    sizes[3] *= factor
    (line,) = odd_sizes(NAMES, sizes)
    assert line.startswith("s3 is ")
    assert guess in line
    stated = float(line.split(" ")[2].replace(",", ""))
    assert stated == pytest.approx(max(factor, 1 / factor), rel=0.1)


def test_several_units_are_several_lines():
    lines = odd_sizes(NAMES, ALIKE * [1, 1000, 1, 1, 1000, 1, 100, 1])
    assert [line.split(" are ")[0].split(" is ")[0] for line in lines] == ["s6", "s1, s4"]


@pytest.mark.parametrize("spread", [0.01, 0.1, 0.2, 0.3])
def test_sizes_that_vary_are_silent(spread):
    rng = np.random.default_rng(0)
    for n in (2, 5, 40):
        for _ in range(50):
            assert odd_sizes([str(i) for i in range(n)], np.exp(spread * rng.normal(size=n))) == []


def test_a_folder_says_so_unless_its_areas_are_made_one(folder, lumps, caplog):
    save(Mesh(1000 * lumps(1)[0].vertices, lumps(1)[0].faces), folder / "s0.off")
    (warning,) = Folder(folder).check()
    assert "s0 is" in warning
    assert "in mm, the others in m?" in warning
    assert Folder(folder, normalise_area=True).check() == []
