"""What a person sees: pictures, reports."""

from lssd_learn.view.painter import paint, save_png

__all__ = ["paint", "save_png"]
