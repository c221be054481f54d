"""What the operators tell about a collection."""

from lssd_learn.exploration.embed import Embedding, pca

__all__ = ["Embedding", "pca"]
