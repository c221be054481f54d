"""Eigenfunctions, consistent functions and those kept: where only the first number is given, the others come down too.

Used by `app.py`.
"""

from collections.abc import Sequence

from lssd_learn.errors import InputError

KEYS = ("basis.k", "latent.size", "latent.keep")


def bring_down(config: dict, typed: Sequence[str]) -> str | None:
    """Lower `latent.size` to `basis.k` and `latent.keep` to `latent.size` where they are above and nobody typed them.

    Args:
        config: plain nested dicts; changed in place.
        typed: the overrides of the command line.

    Returns:
        The line that says so; None where nothing had to come down.

    Raises:
        InputError: a typed number is above what it must not exceed; names all three.
    """
    given = {override.lstrip("+").partition("=")[0] for override in typed}
    numbers = [config["basis"]["k"], config["latent"]["size"], config["latent"]["keep"]]
    if not all(isinstance(n, int) for n in numbers):
        return None  # told of elsewhere
    wanted = list(numbers)
    for i in (1, 2):
        if wanted[i] > wanted[i - 1] >= 1:
            if KEYS[i] in given:
                all_three = " ".join(f"{key}={n}" for key, n in zip(KEYS, numbers, strict=True))
                below = "k" if i == 1 else "size"
                raise InputError(f"{KEYS[i]}={wanted[i]}: expected 1 to {below}={wanted[i - 1]}, but here {all_three}")
            wanted[i] = wanted[i - 1]
    if wanted == numbers:
        return None
    config["latent"]["size"], config["latent"]["keep"] = wanted[1:]
    lowered = [f"{key} from {old}" for key, old, new in zip(KEYS, numbers, wanted, strict=True) if new != old]
    all_three = ", ".join(f"{key}={n}" for key, n in zip(KEYS, wanted, strict=True))
    return f"{all_three}: {' and '.join(lowered)} brought down with it"
