"""Shape differences: what a shape does to areas and to angles, seen from the latent shape; and the register of them.

Everything that goes by the name of a difference follows from `DIFFERENCES`: the channels that nets read, pushes,
checkpoints, tables, baselines and pictures. Another one is a function and a line in a file of its own, in anybody's
package (see `lssd_learn.plugins`):

    register(Difference("bending", bending, tells="how much it bends"))
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.plugins import plugins
from lssd_learn.shapes import Eigenbasis

# Frequencies below this part of λ₁ are null: the constant function's own is noise of either sign, not zero.
NULL = 1e-3
TOGETHER = 4096  # shapes at once: what is made on the way takes as much room as the operators


@dataclass(frozen=True)
class Seen:
    """What a difference is computed from: n shapes, each with k eigenfunctions, seen from one shape with m functions.

    That shape is the latent one; of base-shape differences it is the base.

    Attributes:
        Y: (n, k, m) carries the m functions to each shape.
        evals: (n, k) Λ of the shapes.
        spectrum: (m,) Λ₀, the frequencies of the m functions.
        bases: n eigenbases, which a difference may ask for more; None where they are not at hand.
        source: the shapes whose average is the shape that these are seen from; None: these themselves.
        references: name → (m, m) what has been computed of that average, see `reference`.
    """

    Y: Float[Tensor, "n k m"]
    evals: Float[Tensor, "n k"]
    spectrum: Float[Tensor, " m"]
    bases: Sequence[Eigenbasis] | None = None
    source: "Seen | None" = None
    references: dict[str, Tensor] = field(default_factory=dict)

    def to(self, device: torch.device | str) -> "Seen":
        """The same on another device."""
        return replace(
            self,
            **{name: getattr(self, name).to(device) for name in ("Y", "evals", "spectrum")},
            source=None if self.source is None else self.source.to(device),
            references={name: form.to(device) for name, form in self.references.items()},
        )

    def with_keep(self, keep: int) -> "Seen":
        """Seen by the `keep` lowest functions."""
        return replace(
            self,
            Y=self.Y[:, :, :keep],
            spectrum=self.spectrum[:keep],
            source=None if self.source is None else self.source.with_keep(keep),
            references={name: form[:keep, :keep] for name, form in self.references.items()},
        )


@dataclass(frozen=True)
class Difference:
    """A kind of operator.

    Attributes:
        name: what it is called in `latent.operators=[…]`, tables and pictures.
        compute: `Seen` → (n, m, m) symmetric operators, the form that nets and algebra read. The identity is a shape
            like the one that it is seen from.
        plain: the same in its defining form where that is not symmetric; None where it is.
        constant_is_null: whether the first function, the constant, is null: its row and column vanish.
        unit: what a local size of it is, on maps of where groups differ.
        tells: what a larger αᵀDα says.
        asks: attributes of an eigenbasis that `compute` reads, so that bases without them are refused.
    """

    name: str
    compute: Callable[[Seen], Tensor]
    plain: Callable[[Seen], Tensor] | None = None
    constant_is_null: bool = False
    unit: str = ""
    tells: str = ""
    asks: Sequence[str] = ()

    def __call__(self, seen: Seen) -> Float[Tensor, "n m m"]:
        """(n, m, m) symmetric.

        Raises:
            InputError: eigenbases that are not there, or do not hold what this difference asks for.
        """
        if self.asks:
            if seen.bases is None:
                raise InputError(f"{self.name}: expected a latent space with its eigenbases")
            for i, name in ((i, name) for i in range(len(seen.bases)) for name in self.asks):
                if ask(seen.bases, i, name) is None:
                    raise InputError(f"{self.name}: expected eigenbases with {name}, that of shape {i} has none")
        found = self.compute(seen)
        m = seen.Y.shape[-1]
        if found.shape != (len(seen.Y), m, m):
            raise InputError(f"{self.name}: expected operators {(len(seen.Y), m, m)}, got {tuple(found.shape)}")
        if self.constant_is_null:  # and not nearly: rounding of either sign has no logarithm
            found = found.clone()
            found[:, 0, :] = found[:, :, 0] = 0
        return found

    def tables(self, seen) -> dict[str, Tensor]:
        """name → (n, m, m), as files have them: the defining form by the name, and the symmetric one where it differs.

        Args:
            seen: a `Seen`, or what has its attributes.
        """
        return (
            {self.name: self(seen)}
            if self.plain is None
            else {
                self.name: self.plain(seen),
                f"{self.name}_symmetric": self(seen),
            }
        )


DIFFERENCES: dict[str, Difference] = {}


def ask(bases: Sequence[Eigenbasis], i: int, name: str):
    """What eigenbasis i holds under a name, not opened where the sequence itself knows; None where there is none."""
    known = getattr(bases, name, None)
    return getattr(bases[i], name, None) if known is None else known(i)


def register(difference: Difference) -> Difference:
    """Make a difference known by its name. One of the same module is replaced: a notebook's cell is run twice.

    Raises:
        InputError: a name that one of another module has, or that is no plain word.
    """
    name, module = difference.name, difference.compute.__module__
    if not name.isidentifier():
        raise InputError(f"difference {name!r}: expected a name of letters, digits and _")
    if name in DIFFERENCES and (other := DIFFERENCES[name].compute.__module__) != module:
        raise InputError(f"difference {name!r} of {module}: there is one of this name in {other}")
    DIFFERENCES[name] = difference
    return difference


def check_kinds(kinds: Sequence[str]) -> None:
    """Refuse what are not names of differences.

    Raises:
        InputError: not some of `DIFFERENCES`, each once.
    """
    if any(kind not in DIFFERENCES for kind in kinds):
        plugins()  # which may not have been imported yet
    if not kinds or any(kind not in DIFFERENCES for kind in kinds) or len(set(kinds)) < len(kinds):
        raise InputError(
            f"latent.operators=[{','.join(map(str, kinds))}]: expected some of {', '.join(DIFFERENCES)}, each once"
        )


def stack_differences(seen, kinds: Sequence[str] = ("area",)) -> Float[Tensor, "n channels m m"]:
    """(n, channels, m, m): differences as channels, in their symmetric form.

    Args:
        seen: a `Seen`, or what has its attributes, as a latent space.
        kinds: names of `DIFFERENCES`.

    Raises:
        InputError: as `check_kinds`, and those of a difference.
    """
    check_kinds(kinds)
    (n, _, m), found = seen.Y.shape, None
    for channel, kind in enumerate(kinds):
        one = DIFFERENCES[kind](seen)
        found = one.new_empty(n, len(kinds), m, m) if found is None else found
        found[:, channel] = one  # one kind after the other: of many shapes there is no room for all twice
    return cast(Tensor, found)


def asked(kinds: Sequence[str]) -> set[str]:
    """What some differences read of eigenbases, see `Difference.asks`; nothing for names that there are not."""
    return {name for kind in kinds if kind in DIFFERENCES for name in DIFFERENCES[kind].asks}


def reference(seen, name: str, form: Callable[[Seen], Tensor]) -> Float[Tensor, "m m"]:
    """The average (m, m) of a quadratic form over the shapes whose average is the one that others are seen from.

    Computed once, and kept with the space, its pushes and its files.

    Args:
        seen: a `Seen`, or what has its attributes.
        name: of the difference that is relative to it.
        form: `Seen` → (n, m, m), each carried to the m functions: a matrix of the `keep` lowest is a block of it.
    """
    if name not in seen.references:
        source = seen if seen.source is None else seen.source
        if not len(source.Y):
            raise InputError(
                f"{name}: this latent space was saved before anybody asked it for {name} operators, and no"
                " longer has the shapes that it is the average of; fit it again"
            )
        seen.references[name] = form(source).mean(0)
    return seen.references[name].to(seen.Y)


def area_difference(Y: Float[Tensor, "*n k m"]) -> Float[Tensor, "*n m m"]:
    """D^A = YᵀY (…, m, m), symmetric positive definite; Y (…, k, m)."""
    return Y.transpose(-2, -1) @ Y


def conformal_difference(
    Y: Float[Tensor, "*n k m"], evals: Float[Tensor, "*n k"], spectrum: Float[Tensor, " m"], symmetric: bool = False
) -> Float[Tensor, "*n m m"]:
    """D^C = Λ₀⁺ YᵀΛY (…, m, m), or its symmetric form Λ₀^-½ YᵀΛY Λ₀^-½, which has the same eigenvalues.

    The constant is its null direction, so first row and column vanish in the symmetric form; of shapes in several
    pieces, as many as there are.

    Args:
        Y: (…, k, m).
        evals: Λ (…, k).
        spectrum: Λ₀ (m,).
    """
    inverse = pseudo_inverse(spectrum, pieces(evals))
    if symmetric:
        left, right = inverse.sqrt()[:, None], inverse.sqrt()
    else:
        left, right = inverse[:, None], torch.ones_like(inverse)
    parts = list(zip(Y.split(TOGETHER), evals.split(TOGETHER), strict=True)) if Y.ndim > 2 else [(Y, evals)]
    found = [left * (y.transpose(-2, -1) @ (frequencies[..., :, None] * y)) * right for y, frequencies in parts]
    return found[0] if len(found) == 1 else torch.cat(found)


def pieces(evals: Float[Tensor, "*n k"]) -> int:
    """As many functions are null as all shapes have pieces: their frequencies Λ (…, k) are exactly zero."""
    return max(1, int((evals == 0).sum(-1).min()))


def pseudo_inverse(spectrum: Float[Tensor, " m"], null: int = 1) -> Float[Tensor, " m"]:
    """The diagonal of Λ₀⁺ (m,): zero at the first `null` places and wherever the frequency is below a thousandth of the
    next, which is λ₁."""
    inverse = torch.zeros_like(spectrum)
    if len(spectrum) > null:
        live = spectrum > NULL * spectrum[null]
        live[:null] = False
        inverse[live] = 1 / spectrum[live]
    return inverse


AREA = register(
    Difference(
        name="area",
        compute=lambda seen: area_difference(seen.Y),
        unit="the part of the area there, .1 is 10 %",
        tells="more is larger",
    )
)
CONFORMAL = register(
    Difference(
        name="conformal",
        compute=lambda seen: conformal_difference(seen.Y, seen.evals, seen.spectrum, symmetric=True),
        plain=lambda seen: conformal_difference(seen.Y, seen.evals, seen.spectrum),
        constant_is_null=True,
        tells="functions that change there cost more",
    )
)
