"""A function or class with arguments bound, as a configuration gives it: what it stands for."""

from collections.abc import Callable
from functools import partial
from typing import Any


def parts(function: Callable) -> tuple[Callable, tuple, dict[str, Any]]:
    """The function or class itself and what is bound to it, by place and by name, however often it was bound."""
    arguments, keywords = (), {}
    while isinstance(function, partial):
        arguments, keywords = function.args + arguments, function.keywords | keywords
        function = function.func
    return function, arguments, keywords


def unbound(function: Callable) -> Callable:
    """The function or class itself, whose attributes say what it can do; given plain, it is that already."""
    return parts(function)[0]
