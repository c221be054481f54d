"""A content-addressed store of arrays: what one run computed, the next one reads."""

from lssd_learn.cache.store import DEFAULT, Arrays, Cache, default_root, fingerprint

__all__ = ["DEFAULT", "Arrays", "Cache", "default_root", "fingerprint"]
