"""Fully connected layers, the end of every net here."""

from collections.abc import Sequence

from torch import nn

from lssd_learn.errors import check_whole


def dense(widths: Sequence[int], final_relu: bool = False) -> nn.Sequential:
    """Linear layers of the given widths, input first, with a ReLU between any two and, if asked for, after the last.

    The paper's networks end in a ReLU ("FC-ReLU"). A unit whose ReLU is never positive gets no gradient and stays
    dead, so it is an option and not the default.

    Raises:
        InputError: a width below 1.
    """
    for width in widths:
        check_whole("layer width", width, 1)
    layers: list[nn.Module] = []
    for before, after in zip(widths[:-1], widths[1:], strict=True):
        layers += [nn.Linear(before, after), nn.ReLU()]
    return nn.Sequential(*(layers if final_relu else layers[:-1]))
