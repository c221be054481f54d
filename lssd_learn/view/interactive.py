"""Shapes in a window, to be turned by hand: polyscope, an extra of the package.

The page of `reports` needs no more than a browser; here every field can be switched, rescaled and cut by a plane.
"""

import importlib
import logging
import os
import sys
from collections.abc import Sequence

import numpy as np

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.fields import SIGNED, Field
from lssd_learn.view.scenes import side_by_side, upright

log = logging.getLogger(__name__)

# Polyscope's names of our colours.
COLOURS = {True: "coolwarm", False: "reds"}


def polyscope():
    """The module.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module("polyscope")
    except ModuleNotFoundError as error:
        if error.name != "polyscope":
            raise
        raise InputError("turning shapes by hand needs polyscope: pip install 'lssd_learn[polyscope]'") from None


def ensure_window() -> None:
    """Refuse a window that could not be opened, before the work whose end it is.

    Raises:
        InputError: polyscope is not installed, or there is no display.
    """
    polyscope()
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("task.interactive=true: there is no display here ($DISPLAY is not set) to open a window on")


def show(
    shapes: Sequence[Shape],
    names: Sequence[str],
    fields: Sequence[Field],
    up: str | None = None,
    *,
    backend: str = "auto",
    frames: int | None = None,
) -> None:
    """Open a window and wait until it is closed. Shapes stand side by side, the first field is switched on.

    Args:
        shapes: meshes and clouds.
        names: one a shape.
        fields: functions on these shapes.
        up: the axis that points up in them; None is y.
        backend: of polyscope.
        frames: close after so many; None waits for the user.

    Raises:
        InputError: polyscope is not installed, or can open no window here.
    """
    ps = polyscope()
    if not ps.is_initialized():
        ps.set_verbosity(0)
        ps.set_use_prefs_file(False)  # no .polyscope.ini is left where the program was called
        try:
            ps.init(backend)
        except RuntimeError as error:
            raise InputError(f"polyscope can open no window here: {str(error).splitlines()[0]}") from None
    ps.set_up_dir("y_up")
    ps.remove_all_structures()
    placed = side_by_side([upright(shape.points, up) for shape in shapes])
    for i, (shape, name, points) in enumerate(zip(shapes, names, placed, strict=True)):
        if isinstance(shape, Mesh):
            structure = ps.register_surface_mesh(name, points, np.asarray(shape.faces))
        else:
            structure = ps.register_point_cloud(name, points)
        for j, field in enumerate(fields):
            structure.add_scalar_quantity(
                field.title,
                field.values[i],
                enabled=j == 0,
                vminmax=field.limits,
                cmap=COLOURS[field.colormap == SIGNED],
            )
    log.info("close the window to go on")
    ps.show() if frames is None else ps.show(frames)
