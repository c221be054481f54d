"""The errors of a regression parameter by parameter, in their own units: a table, and lines in the log."""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "parameters.csv"
SHOWN = 20  # parameters in the log; the table has all


def write_errors(
    names: Sequence[str], truth: Float[np.ndarray, "t p"], errors: Mapping[str, Float[np.ndarray, "t p"]], out: Path
) -> None:
    """Write parameters.csv, a row a parameter: its mean and deviation, and of each method the mean absolute error, the
    root mean square error and R², the share of the variance that is explained.

    Args:
        names: p parameters.
        truth: (t, p) on the test split.
        errors: method → (t, p) prediction less truth; the first is the one the log tells.
        out: folder of the run.
    """
    columns: dict[str, Sequence | np.ndarray] = {"parameter": names, "mean": truth.mean(0), "deviation": truth.std(0)}
    for method, error in errors.items():
        square = np.mean(error**2, axis=0)
        spread = np.maximum(truth.var(0), np.finfo(float).tiny)
        columns |= {
            f"{method}/l1": np.abs(error).mean(0),
            f"{method}/rmse": np.sqrt(square),
            f"{method}/r2": np.where(truth.var(0) > 0, 1 - square / spread, np.nan),
        }
    write_columns({name: list(map(_plain, column)) for name, column in columns.items()}, out / TABLE)
    first, *others = errors
    log.info("mean absolute error of %s, parameter by parameter; all of %s: %s", first, ", ".join(errors), out / TABLE)
    for i, name in enumerate(names[:SHOWN]):
        told = [f"{method} {np.abs(errors[method][:, i]).mean():.3g}" for method in others]
        log.info("  %-28s %.3g  (%s)", name, np.abs(errors[first][:, i]).mean(), ", ".join(told))


def _plain(value: Any) -> str | float:
    return value if isinstance(value, str) else float(value)
