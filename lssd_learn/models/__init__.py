"""A trained model as one object: what a checkpoint holds, put in, read out and asked.

model = load("best.ckpt")
model.predict(["a.ply", "b.ply"])
"""

from lssd_learn.models.model import Trained
from lssd_learn.models.trained import load

__all__ = ["Trained", "load"]
