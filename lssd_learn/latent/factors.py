"""Vertex correspondences of a whole collection in factored form: C_ij = B_jᵀ A_i, so that n² maps are never built.

With one connectivity, C_ij = Φ_jᵀ M_j Φ_i. Write Φ_i ≈ Q A_i in a common basis Q of r functions on the vertices; then
B_j = Qᵀ M_j Φ_j does the rest. Q = identity is exact. For large meshes Q holds the principal components of the
collection's own eigenfunctions: they are smooth and much alike, so a few hundred hold them all.
"""

import logging
import math
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.progress import track
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)

SKETCHED_SHAPES = 24  # as many shapes, spread over the collection, are looked at to find Q
# r = 3 k + 50 by default: the operators' eigenvalues are then right to 2e-5 on average, 4e-4 at worst.
RANK_PER_FUNCTION, RANK_MORE = 3, 50
OVERSAMPLING = 1.5  # as many times wider than r is the sketch from which the best r functions are taken
CHUNK = 4  # shapes a matrix product: one alone keeps the processor half idle
# A direction of the sketch is noise where its squared length is below this part of the largest.
NEGLIGIBLE = 1e-10
HELD = 2e9  # bytes of A and B up to which they are held in memory; larger ones lie on the disk


class Spilled:
    """(n, r, k) float32 in a temporary file that nobody else sees and that is gone with this object, or a kill.

    `spilled[2:5] = tensor` writes, `spilled[2:5]`, `spilled[3]` and `spilled[[4, 0]]` read; `$TMPDIR` says where.

    Args:
        shape: (n, r, k).
        device: of the tensors that are read.
    """

    def __init__(self, shape: Sequence[int], device: torch.device | str = "cpu"):
        self.shape, self.device = tuple(shape), torch.device(device)
        self._file = tempfile.TemporaryFile()  # noqa: SIM115  it lives as long as this does
        weakref.finalize(self, self._file.close)
        self._entries = self.shape[1] * self.shape[2]

    def __setitem__(self, some: slice, values: Float[Tensor, "b r k"]) -> None:
        begin, end, _ = some.indices(self.shape[0])
        if tuple(values.shape) != (end - begin, *self.shape[1:]):
            raise ValueError(f"expected {(end - begin, *self.shape[1:])}, got {tuple(values.shape)}")
        self._file.seek(4 * begin * self._entries)
        values.detach().cpu().float().contiguous().numpy().tofile(self._file)

    def __getitem__(self, some: slice | int | Sequence[int]) -> Float[Tensor, "*b r k"]:
        if isinstance(some, slice):
            begin, end, _ = some.indices(self.shape[0])
            return self._read(begin, end - begin)
        if isinstance(some, int):
            return self._read(some, 1)[0]
        return torch.cat([self._read(int(i), 1) for i in some])

    def _read(self, begin: int, count: int) -> Tensor:
        self._file.seek(4 * begin * self._entries)
        array = np.fromfile(self._file, np.float32, count * self._entries)
        return torch.from_numpy(array.reshape(count, *self.shape[1:])).to(self.device)


@dataclass(frozen=True)
class Factors:
    """C_ij = B[j].T @ A[i].

    Attributes:
        A: (n, r, k) coefficients of the eigenfunctions in Q, float64 or, where Q is an approximation anyway, float32;
            of many shapes on the disk.
        B: (n, r, k) products of Q with the eigenfunctions in the measure of each shape.
        lost: the root mean square over the eigenfunctions of what Q misses, relative to their norm.
    """

    A: Float[Tensor, "n r k"] | Spilled
    B: Float[Tensor, "n r k"] | Spilled
    lost: float

    def maps(self, i: int, targets: Sequence[int]) -> Float[Tensor, "d k k"]:
        """C_ij (d, k, k) float64 for each j of d targets."""
        return self.B[targets].mT.double() @ self.A[i].double()


def exact_factors(bases: Sequence[Eigenbasis], device: torch.device | str = "cpu") -> Factors:
    """Factors with Q = identity: r = V. For small meshes, and the oracle of `compressed_factors`."""
    A = torch.stack([_tensor(b.evecs, torch.float64, device) for b in bases])
    M = torch.stack([_tensor(b.mass, torch.float64, device) for b in bases])
    return Factors(A, M[:, :, None] * A, 0.0)


def compressed_factors(
    bases: Sequence[Eigenbasis], rank: int | None = None, seed: int = 0, device: torch.device | str = "cpu"
) -> Factors:
    """Factors with a common basis of `rank` functions, the principal components of some of the eigenbases.

    What Q misses of the eigenfunctions enters C_ij only through its product with what it misses of the weighted ones:
    the error of a map is of second order in `lost`. Every eigenbasis is read a few times at most, a few at once. The
    products with it are float32, whose rounding lies far below what the compression loses; the rest is float64.

    Args:
        bases: eigenbases of one connectivity, k functions each.
        rank: r, by default 3 k + 50; fewer where the eigenbases do not span as many.
        seed: of the random sketch.
    """
    n, (V, k) = len(bases), bases[0].evecs.shape
    most: int = RANK_PER_FUNCTION * k + RANK_MORE if rank is None else rank
    chosen = _spread(n, SKETCHED_SHAPES)
    Zt, mean = _common_basis([bases[i] for i in chosen], most, seed, device)
    root = mean.sqrt()[:, None]

    rank = len(Zt)
    if 2 * 4 * n * rank * k > HELD:
        A, B = (Spilled((n, rank, k), device) for _ in range(2))
    else:
        A, B = (torch.empty(n, rank, k, dtype=torch.float32, device=device) for _ in range(2))
    squares = torch.empty(CHUNK, k, dtype=torch.float64, device=device)
    missed = 0.0  # Σ 1 − ‖Qᵀ M̄ φ‖² / ‖φ‖² over all functions φ
    # A_i = Qᵀ M̄ Φ_i = (M̄^½ Z)ᵀ Φ_i and B_i = Qᵀ M_i Φ_i = (M̄^-½ Z)ᵀ M_i Φ_i
    for_A, for_B = Zt * root.T, Zt / root.T
    plain = torch.empty(V, CHUNK, k, dtype=torch.float32, device=device)
    weighted = torch.empty_like(plain)
    for start in track(range(0, n, CHUNK), "compressing the correspondences"):
        chunk = range(start, min(start + CHUNK, n))
        for place, i in enumerate(chunk):
            basis = bases[i]
            Phi = _tensor(basis.evecs, torch.float32, device)
            mass = _tensor(basis.mass, torch.float32, device)[:, None]
            squares[place] = mean @ (Phi * Phi)
            plain[:, place] = Phi
            torch.mul(mass, Phi, out=weighted[:, place])
        few = [(left @ right.view(V, -1)).view(rank, CHUNK, k) for left, right in ((for_A, plain), (for_B, weighted))]
        few = [products[:, : len(chunk)].transpose(0, 1) for products in few]
        A[chunk.start : chunk.stop], B[chunk.start : chunk.stop] = few
        found = few[0].double().square().sum(1)
        missed += float((1 - found / squares[: len(chunk)]).clamp(min=0).sum())
    lost = (missed / (n * k)) ** 0.5
    log.info("correspondences compressed to %d of %d functions, %.1e of their norm lost", rank, V, lost)
    return Factors(A, B, lost)


def _common_basis(
    bases: Sequence[Eigenbasis], rank: int, seed: int, device: torch.device | str
) -> tuple[Tensor, Tensor]:
    """The principal components of M̄^½ Φ over some shapes, as Zᵀ (r, V) with orthonormal rows, and their mean mass (V,).

    By a randomised range finder (Halko, Martinsson & Tropp 2011): random mixtures of the eigenfunctions span nearly
    all of them; within that span the principal components are a small eigenproblem. M̄ is near every shape's own
    measure, and Q = M̄^-½ Z is orthonormal in it.
    """
    V, k = bases[0].evecs.shape
    width = 32 * math.ceil(OVERSAMPLING * rank / 32)  # others do not fill the registers and take up to twice as long
    width = min(width, len(bases) * k, V)
    generator = torch.Generator(device="cpu").manual_seed(seed)
    sketch = torch.zeros(V, width, dtype=torch.float32, device=device)
    mean = torch.zeros(V, dtype=torch.float64, device=device)
    for basis in bases:
        mixing = torch.randn(k, width, generator=generator).to(device)
        sketch.addmm_(_tensor(basis.evecs, torch.float32, device), mixing)
        mean += _tensor(basis.mass, torch.float64, device) / len(bases)
    mean = mean.float()
    root = mean.sqrt()[:, None]
    sketch *= root
    exact = sketch.double()
    lengths, U = torch.linalg.eigh(exact.T @ exact)
    U = (U / lengths.sqrt())[:, lengths > NEGLIGIBLE * lengths[-1]]  # sketch · U is orthonormal
    inside = torch.zeros(width, width, dtype=torch.float64, device=device)
    for start in range(0, len(bases), CHUNK):
        few = [root * _tensor(basis.evecs, torch.float32, device) for basis in bases[start : start + CHUNK]]
        products = (sketch.T @ torch.cat(few, dim=1)).double()
        inside.addmm_(products, products.T)
    components = U @ torch.linalg.eigh(U.T @ inside @ U)[1].flip(1)[:, :rank]
    return (components.T @ exact.T).float(), mean


def _spread(n: int, most: int) -> list[int]:
    """At most `most` of n positions, evenly, by multiples of the golden section.

    Equal steps would meet a collection that repeats itself, poses in turn or the cycles of a motion, in the same
    phases again and again.
    """
    if n <= most:
        return list(range(n))
    golden = (5**0.5 - 1) / 2
    return sorted({int(n * (i * golden % 1)) for i in range(most)})


def _tensor(array: np.ndarray, dtype: torch.dtype, device: torch.device | str) -> Tensor:
    # A memory-mapped array is read-only, which torch warns about: `array` makes a copy.
    return torch.tensor(np.asarray(array), dtype=dtype, device=device)
