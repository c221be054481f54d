"""Names of shapes as they stand in tables and file names: the same letters may be written in more than one way."""

import unicodedata
from collections.abc import Sequence

from lssd_learn.errors import InputError


def composed(name: str) -> str:
    """A name with its accents in one piece with their letters (NFC): some systems write file names in two pieces."""
    return unicodedata.normalize("NFC", name)


class Names:
    """The names of n shapes, looked up in whichever way they are written.

    Args:
        names: composed, each once.
        files: of the shapes, which may stand in a table in place of the name.
    """

    def __init__(self, names: Sequence[str], files: Sequence[str] = ()):
        self.names = list(names)
        self._position = {composed(file): i for i, file in enumerate(files)} | {n: i for i, n in enumerate(names)}

    def __len__(self) -> int:
        return len(self.names)

    def find(self, name: str) -> int | None:
        """The number of a shape; None if no shape has this name."""
        found = self._position.get(name)
        return self._position.get(composed(name)) if found is None else found

    def position(self, name: str, where: str) -> int:
        """The number of a shape.

        Args:
            name: of the shape or of its file.
            where: file and line, for the message.

        Raises:
            InputError: no shape has this name.
        """
        found = self.find(name)
        if found is None:
            some = ", ".join(self.names[:3]) + (", …" if len(self.names) > 3 else "")
            alike = next((known for known in self.names if _bare(known) == _bare(name)), None)
            hint = f"; {alike!r} is written otherwise" if alike else ""
            raise InputError(f"{where}: expected the name of a shape ({some}), got {name!r}{hint}")
        return found


def _bare(name: str) -> str:
    """Without what is easily overlooked: capitals, accents, spaces, underscores, leading zeros."""
    letters = unicodedata.normalize("NFKD", name).casefold()
    kept = "".join(c for c in letters if c.isalnum())
    return kept.lstrip("0") or kept
