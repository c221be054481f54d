"""A scan in, centimetres out: a reader of body measures that is one file, and needs no body model to read. The one that
comes with the package, `people.npz`, is what `experiment=measures` makes."""

from lssd_learn.models.measuring.reader import BodyReader, Reading
from lssd_learn.models.measuring.training import train_reader

__all__ = ["BodyReader", "Reading", "train_reader"]
