import numpy as np
import pytest

from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.models.table import model_table


@pytest.fixture
def modelled():
    """A function (Y, formula, columns, blocks, kind, permutations) → the table of a model of vectors (n, r)."""

    def make(Y, formula, columns, blocks=None, kind="I", permutations=99, seed=0):
        known = {
            name: np.array(v, dtype=object if np.asarray(v).dtype.kind in "UO" else float)
            for name, v in columns.items()
        }
        made = design(formula, known, [f"shape_{i}" for i in range(len(Y))])
        return model_table(np.asarray(Y, dtype=float), made, strata(made, blocks, "person", permutations, seed), kind)

    return make
