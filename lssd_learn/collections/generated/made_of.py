"""Collections that are made shape by shape of another one. Used by `remeshed.py` and `walled.py`."""

import numpy as np

from lssd_learn.cache import Cache
from lssd_learn.collections.base import Collection


class MadeOf(Collection):
    """Each shape is made of one of `base`, whose names, groups, covariates and parameters it has.

    Args:
        base: n shapes.
    """

    def __init__(self, base: Collection):
        self.base, self.up = base, base.up
        self.names, self.groups, self.covariates = base.names, base.groups, base.covariates
        self.parameter_names = base.parameter_names

    @property
    def parameters(self) -> np.ndarray | None:
        """(n, p) of `base`."""
        return self.base.parameters

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self.base.keep_in(cache, workers)

    def __len__(self) -> int:
        return len(self.base)
