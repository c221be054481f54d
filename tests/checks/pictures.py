"""What a picture shows, roughly: text and axes are grey, what is drawn in them is not."""

import numpy as np
from PIL import Image


def coloured(path):
    """The share of the pixels whose colour is far from a grey."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return float((np.ptp(pixels, axis=2) > 40).mean())
