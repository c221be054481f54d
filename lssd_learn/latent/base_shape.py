"""Shape differences as they were before there was a latent shape: every shape seen from one shape of the collection.

What LSSDs are compared with, since somebody has to choose that shape.
"""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.differences import Seen, stack_differences
from lssd_learn.latent.network import MapNetwork


class BaseShapes:
    """The differences of all shapes from any one of them, the base.

    D^A_bj = C_bjᵀ C_bj and D^C_bj = Λ_b^-½ C_bjᵀ Λ_j C_bj Λ_b^-½, C_bj (k, keep) carrying the `keep` lowest functions
    of the base b to all k of shape j. Of vertex identity the maps are products of the network's factors, and all those
    of a base one matrix product; of large meshes that is right to some tenths of a per cent of the collection's spread.

    Args:
        network: of n shapes with k functions; its edges play no part.
        keep: functions of the base, 1 to k.

    Raises:
        InputError: keep out of range.

    Reference:
        Rustamov, Ovsjanikov, Azencot, Ben-Chen, Chazal and Guibas, "Map-based exploration of intrinsic shape
        differences and variability", ACM Transactions on Graphics 32 (2013).
    """

    def __init__(self, network: MapNetwork, keep: int):
        if not 1 <= keep <= network.k:
            raise InputError(f"keep={keep}: expected 1 to {network.k}, the eigenfunctions a shape")
        self.network, self.keep = network, keep
        self.evals = torch.as_tensor(network.evals)
        if network.maps is None:
            factors = network.factors()
            self._sources = factors.A[:][:, :, :keep].double()
            # All B_jᵀ (n k, r), one below the other: C_bj = B_jᵀ A_b.
            self._targets = factors.B[:].mT.flatten(0, 1).double()

    def maps(self, base: int) -> Float[Tensor, "n k keep"]:
        """C_bj (n, k, keep) of every shape j, float64.

        Raises:
            InputError: of the network's own maps, one that is not there.
        """
        n, k, m = self.network.n, self.network.k, self.keep
        if self.network.maps is None:
            return (self._targets @ self._sources[base]).view(n, k, m)
        return torch.stack([torch.eye(k, m).double() if j == base else self._given(base, j) for j in range(n)])

    def differences(self, base: int, kinds: Sequence[str] = ("area", "conformal")) -> tuple[Tensor, ...]:
        """Differences of some kinds, (n, keep, keep) each, symmetric, float64; the base's own are the identity.

        First row and column of the conformal ones vanish: the constant is their null direction.

        Args:
            base: which shape.
            kinds: see `stack_differences`.

        Raises:
            InputError: of the network's own maps, one that is not there; no such kind.
        """
        k, m, bases, spectrum = self.network.k, self.keep, self.network.bases, self.evals[base, : self.keep]
        source = Seen(torch.eye(k, m).double()[None], self.evals[base][None], spectrum, [bases[base]])
        return stack_differences(Seen(self.maps(base), self.evals, spectrum, bases, source), kinds).unbind(1)

    def _given(self, base: int, j: int) -> Tensor:
        return torch.as_tensor(np.array(self.network.map(base, j)[:, : self.keep]), dtype=torch.float64)
