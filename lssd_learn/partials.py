"""A function or class with arguments bound, as a configuration gives it: what it stands for."""

from collections.abc import Callable
from functools import partial


def unbound(function: Callable) -> Callable:
    """The function or class itself, whose attributes say what it can do; given plain, it is that already."""
    return function.func if isinstance(function, partial) else function
