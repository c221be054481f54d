"""Every collection is looked at once, whole, before a latent space of it is used, even if all its shapes are known.

A new line in a table or a new map leaves the eigenbases in the cache as they are, and would go unread.
"""

import numpy as np

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.base import Collection

STAGE = "checked"
VERSION = 4  # goes up whenever `check` looks at more


def ensure_checked(collection: Collection, cache: Cache | None) -> list[str]:
    """Check a collection, unless the cache knows that these very files have passed; its warnings are said again.

    Returns:
        All that the check said, see `Collection.told`.

    Raises:
        InputError: whatever `collection.check` finds.
    """
    if cache is None or collection.key is None:
        collection.check()
        return list(collection.told())

    def make() -> dict[str, np.ndarray]:
        warnings = np.array(collection.check(), dtype=np.str_)
        return {"warnings": warnings, "told": np.array(collection.told(), dtype=np.str_)}

    found = cache.get(STAGE, fingerprint(STAGE, VERSION, collection.key), make)
    collection.remind(found["warnings"].tolist())
    return found["told"].tolist()
