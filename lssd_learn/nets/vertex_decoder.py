"""From operators to the vertices of a mesh, for collections whose shapes are in vertex correspondence.

The shapes are written in their principal modes, and a kernel machine (`kernel_machine.py`) reads the coefficients from
the logarithms of the operators. All modes share one metric, the sum of what each asks for: a mode counts by how far it
moves the vertices. Each guess is then replaced by the most likely shape near it (`local.py`). Source: of our own.
"""

from collections.abc import Iterator, Sequence
from typing import Any, cast

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.nets.kernel import best_weights, gaussian, slopes
from lssd_learn.nets.kernel_machine import NOISES, KernelMachine
from lssd_learn.nets.local import most_likely

# How many neighbours may count; validation chooses. None leaves the guess as it is.
NEIGHBOURS = (0, 10, 15, 20, 25, 30, 40, 50, 70, 100)

# Modes below this part of the largest are rounding.
NULL = 1e-6


class VertexDecoder(KernelMachine):
    """(n, channels, size, size) symmetric operators → (n, vertices, 3), solved by `solve` and not by gradient descent.

    Args:
        channels: operators a shape: 1 (area or conformal), 2 (both, which is far better) or more.
        size: side of the operators.
        outputs: coordinates to predict, three a vertex.
        modes: principal modes of the training shapes' vertices that are kept, at most.
        neighbours: what to choose from, how many training shapes say which shapes are likely near a guess; 0 leaves
            the guess as it is, which then moves evenly where the training shapes leave gaps.
        rounds, width, floor, noises, components: see `KernelMachine`.

    Raises:
        InputError: an argument out of its range, outputs that are not three a vertex.
    """

    writes = "vertices"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        modes: int = 40,
        neighbours: Sequence[int] = NEIGHBOURS,
        rounds: int = 4,
        width: float = 3.0,
        floor: float = 0.01,
        noises: Sequence[float] = NOISES,
        components: int = 500,
    ):
        check_whole("outputs", outputs, 1)
        if outputs % 3:
            raise InputError(f"outputs={outputs}: expected three coordinates a vertex")
        check_whole("net.modes", modes, 1)
        if not neighbours:
            raise InputError("net.neighbours: expected at least one number to choose from")
        for number in neighbours:
            check_whole("net.neighbours", number, 0)
        super().__init__(channels, size, 0, rounds, width, floor, noises, components)
        self.most_modes, self.choices = modes, tuple(neighbours)
        self.metrics = self.metrics.new_zeros(1, 0, 0)  # one for all
        self.register_buffer("neighbours", torch.tensor(0))
        self.register_buffer("mean_vertices", torch.zeros(outputs))
        # How many modes there are, `solve` says: of the modes themselves, the training shapes and the guesses' error.
        for name, shape in {"modes": (0, outputs), "coefficients": (0, 0), "error": (0, 0)}.items():
            self.register_buffer(name, torch.zeros(shape, dtype=None if name == "modes" else torch.float64))

    def forward(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n vertices 3"]:
        return self.decode(self.encode(operators)).to(operators)

    def encode(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n modes"]:
        """(n, modes) float64: coefficients of the modes, in units of length times √vertices."""
        return self._likely(self._predict(self._components(operators)))

    def decode(self, coefficients: Float[Tensor, "n modes"]) -> Float[Tensor, "n vertices 3"]:
        """(n, vertices, 3) float32 of coefficients (n, modes): linear."""
        return (self.mean_vertices + coefficients.to(self.modes) @ self.modes).unflatten(1, (-1, 3))

    def solve(
        self,
        train: tuple[Float[Tensor, "n channels size size"], Float[Tensor, "n outputs"]],
        validation: tuple[Float[Tensor, "m channels size size"], Float[Tensor, "m outputs"]],
    ) -> Iterator[tuple[Tensor, Tensor]]:
        """Yield the predictions for train and validation after each of the rounds, whose machine this then is.

        Args:
            train: operators (n, channels, size, size), raw and not centred, and vertices (n, outputs).
            validation: the same, to choose each mode's noise and the number of neighbours by.
        """
        (operators, vertices), (others, wanted) = train, validation
        self.shapes = self._look(operators)
        self._find_modes(vertices)
        x, others = self.shapes, self._components(others)
        wanted = (wanted - self.mean_vertices).double() @ self.modes.double().T
        metric, spread = torch.eye(x.shape[1]).to(x), x.T @ x / len(x)
        for _ in range(self.rounds):
            metric = self._scaled(metric, spread)
            self.metrics = metric[None]
            kernel = gaussian(x, x, metric)
            self.weights, missed = self._solve_all(kernel, gaussian(others, x, metric), wanted)
            self.error = missed.T @ missed / len(missed)
            self.neighbours = self._best_neighbours(self._predict(others), wanted)
            pull = cast(Tensor, sum(s.T @ s for s in (slopes(kernel, x, w, metric) for w in self.weights.T)))
            size = pull.trace() / len(pull)
            identity = torch.eye(len(pull)).to(pull)
            metric = (pull / size if size > 0 else identity) + self.floor * identity
            yield self.decode(self._likely(self._predict(x))), self.decode(self._likely(self._predict(others)))

    def _find_modes(self, vertices: Tensor) -> None:
        """Take mean and principal modes of the training shapes, and their coefficients in these."""
        shapes = vertices.double()
        mean = shapes.mean(0)
        # Of a few hundred shapes with many thousand coordinates: by their inner products.
        evals, U = torch.linalg.eigh((shapes - mean) @ (shapes - mean).T)
        some = max(1, min(self.most_modes, int((evals > NULL**2 * evals[-1]).sum())))
        size, U = evals[-some:].flip(0).clamp(min=0).sqrt(), U[:, -some:].flip(1)
        modes = U.T @ (shapes - mean) / size.clamp(min=torch.finfo(size.dtype).tiny)[:, None]
        self.mean_vertices, self.modes, self.coefficients = mean.float(), modes.float(), U * size
        self.mean = torch.zeros(some).to(size)  # of the coefficients

    def _solve_all(self, kernel: Tensor, across: Tensor, wanted: Tensor) -> tuple[Tensor, Tensor]:
        """Weights (n, modes), each with the noise best on validation, and by how much the training shapes are missed
        when each is left out, (n, modes)."""
        evals, V = torch.linalg.eigh(kernel)
        evals, noises = evals.clamp(min=0), self.noises.to(evals)
        inverses = V**2 @ (1 / (evals[:, None] + noises))  # their diagonals, (n, noises)
        weights, missed = [], []
        for target, truth in zip(self.coefficients.T, wanted.T, strict=True):
            chosen, best = best_weights((evals, V), noises, target, across, truth)
            weights.append(chosen)
            missed.append(chosen / inverses[:, best])
        return torch.stack(weights, dim=1), torch.stack(missed, dim=1)

    def _best_neighbours(self, guesses: Tensor, wanted: Tensor) -> Tensor:
        """The number of neighbours best on validation."""
        errors = [((self._likely(guesses, number) - wanted) ** 2).sum() for number in self.choices]
        return torch.tensor(self.choices)[torch.stack(errors).argmin()]

    def _likely(self, guesses: Tensor, neighbours: int | None = None) -> Tensor:
        neighbours = int(self.neighbours) if neighbours is None else neighbours
        return most_likely(guesses, self.coefficients, self.error, neighbours) if neighbours else guesses

    def _predict(self, x: Tensor) -> Tensor:
        """(n, modes) float64 for principal components x (n, r): guesses, not yet `_likely`."""
        return gaussian(x, self.shapes, self.metrics[0]) @ self.weights

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *arguments) -> None:
        for name in ("modes", "coefficients", "error", "mean"):
            if (given := state_dict.get(prefix + name)) is not None:
                setattr(self, name, torch.empty_like(given, device=self.mean.device))
        super()._load_from_state_dict(state_dict, prefix, *arguments)
