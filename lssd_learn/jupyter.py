"""What a notebook shows of a shape, a collection and a latent space: a small picture beside the line of text.

The top of the package registers this where IPython runs; the rooms below know nothing of it.
"""

import io
import sys

WIDE = 6  # shapes of a collection, spread over it
SIZE = 160  # pixels of a shape


def register() -> None:
    """Tell IPython, if this is one of its shells, what to draw; types are named, so that nothing is imported yet."""
    shell = sys.modules["IPython"].get_ipython()
    if shell is None:
        return
    pictures = shell.display_formatter.formatters["image/png"]
    for module, name, draw in (
        ("shapes.mesh", "Mesh", shape_png),
        ("shapes.mesh", "PointCloud", shape_png),
        ("collections.base", "Collection", collection_png),
        ("latent.space", "LatentSpace", latent_png),
    ):
        pictures.for_type_by_name(f"{__package__}.{module}", name, draw)


def shape_png(shape) -> bytes:
    """A shape, seen a little from its left; z is taken to point up."""
    return _painted([shape], None)


def collection_png(collection) -> bytes | None:
    """Some shapes of a collection, spread over it; of an empty one nothing."""
    import numpy as np

    n = len(collection)
    some = np.unique(np.linspace(0, n - 1, min(n, WIDE)).round().astype(int)).tolist() if n else []
    return _painted([collection[i] for i in some], collection.up) if some else None


def latent_png(space) -> bytes:
    """The spectrum of the latent shape, and its shapes as points: area operators in the plane."""
    from lssd_learn.view.charts import latent_chart

    figure, stream = latent_chart(space), io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()


def _painted(shapes: list, up: str | None) -> bytes:
    from PIL import Image

    from lssd_learn.view.painter import paint

    stream = io.BytesIO()
    Image.fromarray(paint(shapes, up=up or "z", size=SIZE)).save(stream, format="png")
    return stream.getvalue()
