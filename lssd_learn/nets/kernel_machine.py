"""A kernel machine on the logarithms of operators that learns, for each output, which directions matter.

With three hundred shapes and thousands of entries an operator, what a net has to find out is where to look. A Gaussian
kernel in the metric M, f(x) = t̄ + Σ_i w_i exp(−½ (x − x_i)ᵀ M (x − x_i)), is solved in closed form, and M is then
replaced by the mean outer product of its gradients: directions along which f is steep count, those along which it is
flat, the pose or the noise of truncation, do not. A few rounds settle it; the one best on validation is kept.

The kernel of all pairs grows with the square of the shapes, its solution with the cube. Of many, the functions are sums
over some of them, the centres, that fit all: see `nystroem.py`.

Where shapes come in blocks, as poses, and are to be read in one that training has not seen, the noise is rehearsed:
each block of the training shapes is left out in turn. A validation split of the same poses asks for far too little.

A kernel machine does not extrapolate: far from all training shapes its answer is their mean. Where validation lies
beyond training, in its shapes or in what is to be predicted, an output that a ridge on the same x predicts better there
is the ridge's, without bounds.

Source: Radhakrishnan, Beaglehole, Pandit & Belkin, "Mechanism for feature learning in neural networks and
backpropagation-free machine learning models", Science 2024 (recursive feature machines).
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.nets import nystroem
from lssd_learn.nets.kernel import best_weights, gaussian, rehearsed_noise, slopes
from lssd_learn.operators.vectors import live_functions, log_features

# Added to the diagonal of a kernel whose own is 1; each output takes the one best on validation.
NOISES = tuple(np.logspace(-8, -1, 22))
# Validation lies beyond training if more than so large a part of an output's values is outside its range there, or of
# its shapes farther from all training shapes than 95 of 100 of these are from each other.
OUTSIDE, FAR = 0.05, 0.2
TOGETHER = 1024  # shapes whose kernels are held at once
LOGARITHMS = 8192  # shapes whose logarithms are taken at once
MANY = 5000  # shapes of which all distances are looked at


class KernelMachine(nn.Module):
    """(n, channels, size, size) symmetric operators → (n, outputs), solved by `solve` and not by gradient descent.

    x holds the logarithms of all channels, without the functions that are null on every training shape. Distances of
    logarithms do not depend on the basis of the latent space: flipping the signs of its functions, or turning it,
    changes no prediction (of a machine trained after the change).

    Args:
        channels: operators a shape: 1 (area or conformal), 2 (both, which is far better) or more.
        size: side of the operators.
        outputs: numbers to predict.
        rounds: of solving and renewing the metrics; the first uses the plain distance.
        width: of the Gaussian, in root mean square deviations of the training shapes from their mean.
        floor: part of the identity in every metric, so that no direction is given up for good.
        noises: what to choose each output's noise from: added to the diagonal of the kernel, which is 1.
        components: at most so many principal directions of the training shapes are looked at.
        bounded: keep every output within its range on the training shapes, as befits parameters drawn from an interval;
            a shape unlike them all cannot lead far astray then. Outputs of a ridge have no bounds.
        exact: of more training shapes than these, `centres` of them stand for all in what is solved.
        centres: that many, drawn at random, the same every time.

    Raises:
        InputError: an argument out of its range.
    """

    reads = "operators"
    rehearses = True

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        rounds: int = 8,
        width: float = 3.0,
        floor: float = 0.01,
        noises: Sequence[float] = NOISES,
        components: int = 500,
        bounded: bool = True,
        exact: int = 5000,
        centres: int = 1000,
    ):
        super().__init__()
        check_whole("net.exact", exact, 1)
        check_whole("net.centres", centres, 2)
        check_whole("net.rounds", rounds, 1)
        check_whole("net.components", components, 1)
        for name, value in (("width", width), ("floor", floor), *(("noises", noise) for noise in noises)):
            check_positive(f"net.{name}", value)
        self.rounds, self.width, self.floor, self.components = rounds, width, floor, components
        self.bounded, self.exact, self.centres = bounded, exact, centres
        self.noises = torch.tensor(sorted(noises), dtype=torch.float64)
        # Float64 throughout: with little noise the weights are large and cancel. Empty until solved or loaded.
        empty = {"centre": (0,), "directions": (0, 0), "shapes": (0, 0), "metrics": (outputs, 0, 0)}
        for name, shape in {**empty, "weights": (0, outputs), "ridge": (0, outputs), "mean": (outputs,)}.items():
            self.register_buffer(name, torch.zeros(shape, dtype=torch.float64))
        self.register_buffer("bounds", torch.tensor([[-torch.inf], [torch.inf]]).double().repeat(1, outputs))
        self.register_buffer("linear", torch.zeros(outputs, dtype=torch.bool))
        self.register_buffer("live", torch.zeros(channels, size, dtype=torch.bool))

    def forward(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n outputs"]:
        return self._predict(self._components(operators)).to(operators)

    def solve(
        self,
        train: tuple[Float[Tensor, "n channels size size"], Float[Tensor, "n outputs"]],
        validation: tuple[Float[Tensor, "m channels size size"], Float[Tensor, "m outputs"]],
        blocks: Int[Tensor, " n"] | None = None,
    ) -> Iterator[tuple[Tensor, Tensor]]:
        """Yield the predictions for train and validation after each of the rounds, whose machine this then is.

        Args:
            train: operators (n, channels, size, size), raw and not centred, and what to aim at (n, outputs).
            validation: the same, to choose each output's noise by.
            blocks: (n,) of the training shapes, to choose it by instead: each block is left out in turn.

        Raises:
            InputError: one block alone, or with blocks more training shapes than `exact`.
        """
        (operators, targets), (others, wanted) = train, validation
        if blocks is not None and len(blocks.unique()) < 2:
            raise InputError("data.rehearse: expected training shapes of two labels or more, got one")
        if blocks is not None and len(operators) > self.exact:
            raise InputError(
                f"data.rehearse: expected at most net.exact={self.exact} training shapes, got {len(operators)}"
            )
        x, targets, wanted = self._look(operators), targets.double(), wanted.double()
        others = self._components(others)
        self.shapes = x if len(x) <= self.exact else x[_drawn(len(x), self.centres)]
        self.mean = targets.mean(0)
        if self.bounded:
            self.bounds = torch.stack([targets.amin(0), targets.amax(0)])
        spread = x.T @ x / len(x)
        self.ridge = self._solve_ridge(x, others, targets - self.mean, wanted - self.mean, blocks)
        outside = ((wanted < targets.amin(0)) | (wanted > targets.amax(0))).double().mean(0)
        beyond = (outside > OUTSIDE) | (_far(x, others) > FAR)
        straight = (self.mean + others @ self.ridge - wanted).square().mean(0)
        metrics = torch.eye(x.shape[1]).to(x).expand(len(self.metrics), -1, -1)
        solve = partial(self._solve_one, blocks=blocks) if len(x) <= self.exact else self._solve_many
        for _ in range(self.rounds):
            self.metrics = torch.stack([self._scaled(metric, spread) for metric in metrics])
            solved = [
                solve(metric, x, others, targets[:, o] - self.mean[o], wanted[:, o] - self.mean[o])
                for o, metric in enumerate(self.metrics)
            ]
            self.weights = torch.stack([weights for weights, _ in solved], dim=1)
            metrics = torch.stack([metric for _, metric in solved])
            self.linear = torch.zeros_like(self.linear)
            self.linear = beyond & (straight < (self._predict(others) - wanted).square().mean(0))
            yield self._predict(x), self._predict(others)

    def _look(self, operators: Tensor) -> Tensor:
        """(n, r) the principal components of the training shapes, whose live functions and directions are taken."""
        self.live = live_functions(operators)
        logarithms = self._logarithms(operators)
        self.centre = logarithms.mean(0)
        logarithms -= self.centre
        if len(logarithms) <= self.exact:
            U, s, Vt = torch.linalg.svd(logarithms, full_matrices=False)
            some = min(int((s > 1e-6 * s[0]).sum()), self.components)
            self.directions = Vt[:some].T.contiguous()
            return U[:, :some] * s[:some]
        squares, V = torch.linalg.eigh(logarithms.T @ logarithms)
        some = min(int((squares > 1e-12 * squares[-1]).sum()), self.components)
        self.directions = V.flip(1)[:, :some].contiguous()
        return logarithms @ self.directions

    def _components(self, operators: Tensor) -> Tensor:
        """(n, r) float64: the logarithms in the principal directions of the training shapes."""
        return (self._logarithms(operators) - self.centre) @ self.directions

    def _logarithms(self, operators: Tensor) -> Tensor:
        """(n, d) float64, some shapes at a time."""
        return torch.cat([log_features(some, self.live) for some in operators.split(LOGARITHMS)])

    def _scaled(self, metric: Tensor, spread: Tensor) -> Tensor:
        """The metric in which the root mean square deviation of the training shapes is 1 / width."""
        return metric / ((metric * spread).sum() * self.width**2).clamp(min=torch.finfo(metric.dtype).tiny)

    def _solve_one(
        self, metric: Tensor, x: Tensor, others: Tensor, target: Tensor, wanted: Tensor, blocks: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """Weights (n,) of one output, with the noise that was best, and the metric its gradients ask for."""
        kernel = gaussian(x, x, metric)
        evals, V = torch.linalg.eigh(kernel)
        spectrum, across = (evals.clamp(min=0), V), gaussian(others, x, metric)
        noises = self._noises(kernel, target, blocks)
        weights, _ = best_weights(spectrum, noises, target, across, wanted)
        return weights, self._renewed(slopes(kernel, x, weights, metric))

    def _solve_many(
        self, metric: Tensor, x: Tensor, others: Tensor, target: Tensor, wanted: Tensor
    ) -> tuple[Tensor, Tensor]:
        """The same of the centres, fitted to all; the gradients are those at the centres."""
        found = nystroem.spectrum(x, self.shapes, metric, target)
        weights = nystroem.weights(found, self.noises.to(x), gaussian(others, self.shapes, metric), wanted)
        return weights, self._renewed(slopes(gaussian(self.shapes, self.shapes, metric), self.shapes, weights, metric))

    def _renewed(self, gradients: Tensor) -> Tensor:
        """The metric (r, r) that gradients (c, r) ask for."""
        outer, identity = gradients.T @ gradients, torch.eye(gradients.shape[1]).to(gradients)
        size = outer.trace() / len(outer)
        return (outer / size if size > 0 else identity) + self.floor * identity

    def _noises(self, kernel: Tensor, target: Tensor, blocks: Tensor | None) -> Tensor:
        """The noises that validation may choose from: all, or the one that was best in rehearsal."""
        noises = self.noises.to(kernel)
        return noises if blocks is None else noises[rehearsed_noise(kernel, noises, target, blocks)][None]

    def _solve_ridge(self, x: Tensor, others: Tensor, targets: Tensor, wanted: Tensor, blocks: Tensor | None) -> Tensor:
        """Weights (r, outputs) of ridges on the components, each with the noise that was best."""
        if len(x) > self.exact:
            return nystroem.ridges(x, targets, others, wanted, self.noises.to(x))
        scale = float((x**2).sum() / len(x)) or 1.0  # so that the kernel's diagonal is 1 in the mean
        kernel = x @ x.T / scale
        evals, V = torch.linalg.eigh(kernel)
        spectrum, across = (evals.clamp(min=0), V), others @ x.T / scale
        dual = [
            best_weights(spectrum, self._noises(kernel, t, blocks), t, across, w)[0]
            for t, w in zip(targets.T, wanted.T, strict=True)
        ]
        return x.T @ torch.stack(dual, dim=1) / scale

    def _predict(self, x: Tensor) -> Tensor:
        """(n, outputs) float64 for principal components x (n, r)."""
        return torch.cat([self._predict_some(some) for some in x.split(TOGETHER)])

    def _predict_some(self, x: Tensor) -> Tensor:
        kernels = torch.stack([gaussian(x, self.shapes, metric) for metric in self.metrics])
        found = (self.mean + torch.einsum("onc,co->no", kernels, self.weights)).clamp(*self.bounds)
        return torch.where(self.linear, self.mean + x @ self.ridge, found) if self.linear.any() else found

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *arguments) -> None:
        # How many shapes and directions there are, only the checkpoint knows.
        state_dict.setdefault(prefix + "linear", torch.zeros_like(self.linear))  # of one trained before there was any
        state_dict.setdefault(prefix + "ridge", torch.zeros_like(self.ridge))
        for name in ("centre", "directions", "shapes", "metrics", "weights", "ridge"):
            if (given := state_dict.get(prefix + name)) is not None:
                setattr(self, name, torch.empty_like(given, device=self.mean.device))
        super()._load_from_state_dict(state_dict, prefix, *arguments)


def _drawn(n: int, count: int) -> Tensor:
    """`count` of n positions at random, ascending, the same every time."""
    return torch.from_numpy(np.sort(np.random.default_rng(0).choice(n, min(n, count), replace=False)))


def _far(x: Tensor, others: Tensor) -> float:
    """The part of `others` (m, r) that is farther from all of x (n, r) than 95 of 100 of these are from each other. Of
    many shapes some stand for all."""
    x, others = (part if len(part) <= MANY else part[_drawn(len(part), MANY)] for part in (x, others))
    if len(x) < 2:
        return 0.0
    own = torch.cdist(x, x).fill_diagonal_(torch.inf).amin(1)
    return float((torch.cdist(others, x).amin(1) > own.quantile(0.95)).double().mean())
