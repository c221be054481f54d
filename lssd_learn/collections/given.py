"""Many shapes as a person has them at hand, made a collection: a folder, files, objects of trimesh, a plain list."""

import os
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection, ShapeList
from lssd_learn.collections.folder import Folder
from lssd_learn.collections.reading.mask import Masks
from lssd_learn.collections.reading.shape import read_shape
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError
from lssd_learn.shapes import Shape, as_shape
from lssd_learn.shapes.given import Given, content_key, described, is_one, warn_of_unmended

PATH = (str, os.PathLike)
UNMASKED = Masks(None, Path(), ())


class AtHand(ShapeList):
    """A list of shapes, each one of those that `as_shape` takes. Files are read when their shape is asked for, as those
    of a folder are.

    The cache knows them by what they hold, so that the same mesh is found again in another list, or in a fold of a
    cross-validation. Names are those of the files, or positions.

    Args:
        given: n of them.
    """

    def __init__(self, given: Iterable[Given]):
        super().__init__(())
        items = list(given)
        self._told = Told()
        names = [Path(item).stem if isinstance(item, PATH) else str(i) for i, item in enumerate(items)]
        self.names = names if len(set(names)) == len(names) else [str(i) for i in range(len(names))]
        self._shapes = [
            item if isinstance(item, PATH) else as_shape(item, f"shapes[{i}]") for i, item in enumerate(items)
        ]
        warn_of_unmended({f"shapes[{i}]": s for i, s in enumerate(self._shapes) if not isinstance(s, PATH)})

    def __getitem__(self, i: int) -> Shape:
        item = self._shapes[i]
        if not isinstance(item, PATH):
            return item
        return read_shape(Path(item).expanduser(), i, None, UNMASKED, self._told).shape

    @cached_property
    def key(self) -> str:
        """Depends on all that the shapes hold, and on their names."""
        return fingerprint("shapes at hand", self._contents, self.names)

    def shape_key(self, i: int) -> str:
        return self._contents[i]

    @cached_property
    def _contents(self) -> list[str]:
        return [content_key(self[i]) for i in range(len(self))]


def as_collection(shapes: Sequence[Given] | str | os.PathLike) -> Collection:
    """`shapes` itself if it is a collection; a folder as `Folder`, with its tables and maps; a sequence as `AtHand`.

    Raises:
        InputError: one shape in place of several, or something that is no shape.
    """
    if isinstance(shapes, Collection):
        return shapes
    if isinstance(shapes, PATH):
        if Path(shapes).is_file():
            raise InputError(f"shapes: expected a folder or several shapes, got one file: write [{str(shapes)!r}]")
        return Folder(os.fspath(shapes))
    if is_one(shapes):
        raise InputError(f"shapes: expected several in a sequence, got one {described(shapes)}: write [shape]")
    if not isinstance(shapes, Iterable):
        raise InputError(f"shapes: expected a collection, a folder or a sequence of shapes, got {described(shapes)}")
    return AtHand(shapes)
