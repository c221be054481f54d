"""What the tests check of a signature at run time: arrays, their shapes and their kinds.

Importing this, as `conftest.py` does first of all, has jaxtyping put `arrays` on every function and dataclass of the
rooms. What else a signature says is for the type checker: NumPy's whole numbers and truth values are none of Python's.
"""

from collections.abc import Callable
from typing import Any, get_args

from beartype import BeartypeConf, beartype
from jaxtyping import AbstractArray, install_import_hook

# Of learning all but the modules of Lightning: to load a checkpoint it looks at the arguments of their constructors,
# and does not see them behind the hook.
LEARNING = ("batches", "evaluation", "references", "scores")
ROOMS = (
    "shapes", "collections", "maps", "latent", "differentiable", "operators", "exploration", "nets", "models",
    "pipeline", "pushing", "estimator", "division", *(f"learning.{file}" for file in LEARNING),
)  # fmt: skip

# Made of whatever makes an array, which they check themselves.
ENTRIES = {"Mesh", "UnrelatedMesh", "PointCloud"}

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))  # a float may be a whole number


def arrays(function: Callable) -> Callable:
    """The function, its arguments and result checked where their annotations name an array of some shape."""
    hints = {name: hint for name, hint in function.__annotations__.items() if names_array(hint)}
    if not hints or function.__qualname__.removesuffix(".__init__") in ENTRIES:
        return function
    function.__annotations__ = hints
    return checked(function)


def names_array(hint: Any) -> bool:
    """Whether an annotation is, or holds, one of jaxtyping's."""
    if isinstance(hint, list):  # the arguments of a Callable
        return False
    return (isinstance(hint, type) and issubclass(hint, AbstractArray)) or any(map(names_array, get_args(hint)))


install_import_hook([f"lssd_learn.{room}" for room in ROOMS], "shape_checks.arrays")
