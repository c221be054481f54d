"""The latent space of a collection: the one object that speaks for all its shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.cache import Cache
from lssd_learn.collections.picking import Picking
from lssd_learn.errors import InputError
from lssd_learn.latent import storage
from lssd_learn.latent.basis import canonical_basis, consistent_basis
from lssd_learn.latent.differences import Seen, area_difference, conformal_difference, stack_differences
from lssd_learn.latent.network import MapNetwork
from lssd_learn.latent.push import push_least_squares, push_nearest
from lssd_learn.latent.region import find_region
from lssd_learn.shapes import Eigenbasis


@dataclass(frozen=True)
class Pushed:
    """A shape in a latent space it was not fitted in.

    Attributes:
        basis: Y (k, m).
        seen: what its differences are computed from, of this one shape.
    """

    basis: Float[Tensor, "k m"]
    seen: Seen

    @property
    def area(self) -> Float[Tensor, "m m"]:
        """D^A (m, m)."""
        return area_difference(self.basis)

    @property
    def conformal(self) -> Float[Tensor, "m m"]:
        """D^C (m, m) in its symmetric form, the one that nets, logarithms and all of `operators` read."""
        return self.differences(symmetric=True)[1]

    def differences(self, symmetric: bool = False) -> tuple[Float[Tensor, "m m"], Float[Tensor, "m m"]]:
        """Area and conformal difference (m, m) each, as `LatentSpace.differences` gives them of its shapes."""
        return self.area, conformal_difference(self.basis, self.seen.evals[0], self.seen.spectrum, symmetric)

    def difference(self, kind: str) -> Float[Tensor, "m m"]:
        """(m, m) any of `DIFFERENCES`, symmetric.

        Raises:
            InputError: as `stack_differences`.
        """
        return stack_differences(self.seen, [kind])[0, 0]

    def __repr__(self) -> str:
        return f"Pushed({self.basis.shape[0]} functions, {self.basis.shape[1]} latent)"


@dataclass(frozen=True, eq=False)
class LatentSpace:
    """A canonical consistent latent basis and what follows from it. Made by `fit`.

    Attributes:
        Y: (n, k, m) canonical bases: Y[i] carries functions on the latent shape to shape i; m = keep.
        evals: (n, k) Λ of the shapes.
        spectrum: (m,) Λ₀, the frequencies of the latent shape.
        U: (size, m) the rotation from the consistent to the canonical basis.
        energy: (size,) what each consistent function costs in the network.
        bases: n eigenbases, needed only to show functions on the shapes; None where they are not at hand.
        names: of the shapes, n or none.
        source: the shapes whose average the latent shape is; None: these, as after `fit`.
        references: what of that average has been computed, see `differences.reference`.

    Examples:
        >>> import lssd_learn as lssd
        >>> spheres = lssd.collections.Bumps(subdivisions=2)
        >>> bases = [lssd.eigenbasis(sphere, k=12) for sphere in spheres]
        >>> latent = lssd.LatentSpace.fit(lssd.MapNetwork.clique(bases), size=9, keep=4)
        >>> area, conformal = latent.differences()
        >>> tuple(area.shape)
        (4, 4, 4)
        >>> area.mean(0).diag().round(decimals=6).tolist()  # the latent shape is their average
        [1.0, 1.0, 1.0, 1.0]
    """

    Y: Float[Tensor, "n k m"]
    evals: Float[Tensor, "n k"]
    spectrum: Float[Tensor, " m"]
    U: Float[Tensor, "size m"]
    energy: Float[Tensor, " size"]
    bases: Sequence[Eigenbasis] | None = None
    names: Sequence[str] = ()
    source: Seen | None = None
    references: dict[str, Tensor] = field(default_factory=dict)

    @classmethod
    def fit(
        cls,
        network: MapNetwork,
        size: int | None = None,
        keep: int | None = None,
        *,
        method: str = "auto",
        rank: int | None = None,
        tolerance: float | None = None,
        names: Sequence[str] = (),
        device: torch.device | str = "cpu",
    ) -> "LatentSpace":
        """The latent space of a network: `size` consistent functions made canonical, the `keep` lowest kept.

        Args:
            network: n shapes, k functions each.
            size: 1 … k; by default four fifths of k, which drops what truncation spoils.
            keep: 1 … size; by default half of k.
            method, rank, device: see `MapNetwork.form`.
            tolerance: of the eigensolver, see `consistent_basis`.
            names: of the shapes.
        """
        size = max(1, network.k * 4 // 5) if size is None else size
        keep = max(1, min(size, network.k // 2)) if keep is None else keep
        if not 1 <= size <= network.k:
            raise InputError(f"size={size}: expected 1 to {network.k}, the number of eigenfunctions a shape")
        if not 1 <= keep <= size:
            raise InputError(f"keep={keep}: expected 1 to size={size}")
        consistent = consistent_basis(network.form(method, rank, device), size, tolerance)  # the form is large: let go
        evals = torch.tensor(network.evals, dtype=torch.float64, device=device)
        Y, U, spectrum = canonical_basis(consistent.Y, evals, overwrite=True)
        return cls(
            Y if keep == size else Y[:, :, :keep].clone(), evals, spectrum[:keep].clone(), U[:, :keep].clone(),
            consistent.energy, network.bases, tuple(names),
        )  # fmt: skip

    def to(self, device: torch.device | str) -> "LatentSpace":
        """The same space on another device."""
        names = ("Y", "evals", "spectrum", "U", "energy")
        seen = replace(self.seen, source=self.source).to(device)
        tensors = {name: getattr(self, name).to(device) for name in names}
        return replace(self, **tensors, source=seen.source, references=seen.references)

    def __len__(self) -> int:
        return len(self.Y)

    def __repr__(self) -> str:
        size = len(self.energy)
        return f"LatentSpace({len(self):,} shapes of {self.Y.shape[1]} functions, size={size}, keep={self.keep})"

    @property
    def keep(self) -> int:
        """m, the number of canonical functions."""
        return self.Y.shape[2]

    @property
    def seen(self) -> Seen:
        """What differences are computed from, of all its shapes."""
        return Seen(self.Y, self.evals, self.spectrum, self.bases, self.source, self.references)

    def with_shapes(
        self,
        Y: Float[Tensor, "s k m"],
        evals: Float[Tensor, "s k"],
        bases: Sequence[Eigenbasis] | None,
        names: Sequence[str] = (),
    ) -> "LatentSpace":
        """Other shapes, seen from the same latent shape."""
        source = self.source or self.seen
        return replace(self, Y=Y, evals=evals, bases=bases, names=tuple(names), source=source)

    def some(self, positions: Sequence[int] | np.ndarray) -> "LatentSpace":
        """Some of its shapes, seen from the same latent shape."""
        positions, bases = list(map(int, positions)), self.bases
        if bases is not None:
            bases = bases[positions] if isinstance(bases, Picking) else [bases[i] for i in positions]
        names = [self.names[i] for i in positions] if self.names else ()
        return self.with_shapes(self.Y[positions], self.evals[positions], bases, names)

    def averaging(self, positions: Sequence[int] | np.ndarray) -> "LatentSpace":
        """The same space, where the latent shape is the average of these of its shapes: others were pushed into it."""
        source = replace(self.some(positions).seen, source=None, references={})
        return replace(self, source=source, references={})

    def differences(self, symmetric: bool = False) -> tuple[Float[Tensor, "n m m"], Float[Tensor, "n m m"]]:
        """Area and conformal differences (n, m, m) each of all shapes; `symmetric` chooses the form of the latter."""
        return area_difference(self.Y), conformal_difference(self.Y, self.evals, self.spectrum, symmetric)

    def basis(self, i: int) -> Float[Tensor, "k m"]:
        """Y_i (k, m), the canonical latent basis in the eigenfunctions of shape i."""
        return self.Y[i]

    def eigenbasis(self, i: int) -> Eigenbasis:
        """Λ, Φ and M of shape i, of `bases`.

        Raises:
            InputError: the space was loaded without them.
        """
        if self.bases is None:
            raise InputError("this latent space was loaded without its eigenbases; give `bases` when loading it")
        return self.bases[i]

    def map(self, i: int, j: int) -> Float[Tensor, "k k"]:
        """C_ij ≈ Y_j Y_i⁺ (k, k): functions on shape i through the latent shape to shape j."""
        return self.Y[j] @ torch.linalg.pinv(self.Y[i])

    def to_shape(self, alpha, i: int) -> Float[Tensor, " V *p"]:
        """A function on the latent shape, alpha (m,) or (m, p), as values (V,) or (V, p) at the vertices of shape i."""
        Phi = torch.tensor(np.asarray(self.eigenbasis(i).evecs), dtype=self.Y.dtype, device=self.Y.device)
        return Phi @ (self.Y[i] @ torch.as_tensor(alpha).to(self.Y))

    def from_shape(self, values, i: int) -> Float[Tensor, " m *p"]:
        """The function (m,) or (m, p) on the latent shape nearest to values (V,) or (V, p) on shape i."""
        basis = self.eigenbasis(i)
        weighted = np.asarray(basis.evecs, dtype=float).T * np.asarray(basis.mass)
        coefficients = torch.as_tensor(weighted).to(self.Y) @ torch.as_tensor(np.asarray(values)).to(self.Y)
        return torch.linalg.pinv(self.Y[i]) @ coefficients

    def region(self, masks, threshold: float = 0.5) -> Float[Tensor, "m r"]:
        """F (m, r), orthonormal functions on the latent shape that live on a region of the shapes.

        Args:
            masks: (V,) bool for shapes in vertex correspondence, or a sequence of n, one (V_i,) a shape.
            threshold: the part of each function that must lie on the region at least, see `find_region`.
        """
        return find_region(self, masks, threshold).functions

    def neighbours(self, evals, p: int = 5) -> list[int]:
        """The p shapes whose spectra are nearest to `evals` (k,): those to push a new shape from."""
        if p < 1 or np.shape(evals) != (self.evals.shape[1],):
            raise InputError(
                f"neighbours: expected {self.evals.shape[1]} eigenvalues, p ≥ 1; got {np.shape(evals)}, {p}"
            )
        distance = (self.evals - torch.tensor(np.asarray(evals)).to(self.evals)).norm(dim=1)
        return torch.argsort(distance, stable=True)[:p].tolist()

    def push(self, basis: Eigenbasis, maps: Mapping[int, tuple], method: str = "least_squares") -> Pushed:
        """A new shape in this space, without fitting it again.

        Args:
            basis: k eigenfunctions of the new shape.
            maps: neighbour i → (C_i→new, C_new→i), both (k, k); see `neighbours`.
            method: "least_squares" over all the neighbours, or "nearest", the paper's: the first neighbour's alone.
        """
        if not maps or method not in ("least_squares", "nearest"):
            raise InputError(f"push: expected maps and least_squares or nearest, got {len(maps)} maps and {method!r}")
        sizes = (len(basis.evals), self.Y.shape[1])
        for i, (to_new, from_new) in maps.items():
            if np.shape(to_new) != sizes or np.shape(from_new) != sizes[::-1]:
                got = f"{np.shape(to_new)} and {np.shape(from_new)}"
                raise InputError(f"push: expected maps of {sizes} and {sizes[::-1]} for shape {i}, got {got}")
        Ys = [self.Y[i] for i in maps]
        there = [torch.as_tensor(to_new).to(self.Y) for to_new, _ in maps.values()]
        back = [torch.as_tensor(from_new).to(self.Y) for _, from_new in maps.values()]
        Y = push_nearest(Ys[0], there[0]) if method == "nearest" else push_least_squares(Ys, there, back)
        evals = torch.as_tensor(np.array(basis.evals)).to(self.Y)
        source = self.source or self.seen
        return Pushed(Y, Seen(Y[None], evals[None], self.spectrum, [basis], source, self.references))

    def with_keep(self, keep: int) -> "LatentSpace":
        """The same space cut to its `keep` lowest functions."""
        if not 1 <= keep <= self.keep:
            raise InputError(f"keep={keep}: expected 1 to {self.keep}")
        seen = self.seen.with_keep(keep)
        return replace(
            self, Y=seen.Y, spectrum=seen.spectrum, U=self.U[:, :keep], source=seen.source, references=seen.references
        )

    def save(self, path: str | Path, bases: bool = False) -> Path:
        """Write the space to one `.npz` file of megabytes; with `bases` the eigenbases go in, and it stands alone."""
        return storage.save(self, path, bases)

    def state(self) -> dict:
        """Plain tensors and lists, for a checkpoint: all but the eigenbases, which it names by their cache keys."""
        return storage.to_state(self)

    @classmethod
    def load(cls, path: str | Path, cache: Cache | None = None) -> "LatentSpace":
        """Read what `save` wrote, or the latent space a checkpoint (`.ckpt`) was trained in.

        Eigenbases that are not inside are looked up in `cache` when first needed.
        """
        return storage.load(cls, path, cache)
