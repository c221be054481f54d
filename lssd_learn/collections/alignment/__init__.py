"""How the shapes of a collection are to be laid so that they lie alike: found, and told. `aligned.py` lays them."""

from lssd_learn.collections.alignment.lie import ALIGN, VERSION, Lie, find
from lssd_learn.collections.alignment.told import tell

__all__ = ["ALIGN", "VERSION", "Lie", "find", "tell"]
