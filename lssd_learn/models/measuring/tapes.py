"""Where the tape lies on a scan: loops around a known body that go along to where its vertices lie."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.collections.anthropometry.sections import between


@dataclass(frozen=True, eq=False)
class Loop:
    """A closed polygon around a body, each corner on an edge.

    Attributes:
        ends: (h, 2) vertices.
        share: (h,) of the way from the first to the second.
    """

    ends: Int[np.ndarray, "h 2"]
    share: Float[np.ndarray, " h"]

    def on(self, points: Float[np.ndarray, "V 3"]) -> Float[np.ndarray, "h 3"]:
        """(h, 3) its corners, where the vertices lie at these points."""
        return between(points, self.ends, self.share)


def packed(loops: Mapping[str, Loop]) -> dict[str, np.ndarray]:
    """Loops as arrays for a file."""
    ends, shares = np.empty((0, 2), dtype=np.int32), np.empty(0, dtype=np.float32)
    return {
        "loop_names": np.array(list(loops), dtype=np.str_),
        "loop_counts": np.array([len(loop.share) for loop in loops.values()], dtype=np.int32),
        "loop_ends": np.concatenate([ends, *(loop.ends for loop in loops.values())]).astype(np.int32),
        "loop_shares": np.concatenate([shares, *(loop.share for loop in loops.values())]).astype(np.float32),
    }


def unpacked(arrays: Mapping[str, np.ndarray]) -> dict[str, Loop]:
    """What `packed` made arrays of."""
    names, after = arrays["loop_names"].tolist(), np.cumsum(arrays["loop_counts"])[:-1]
    ends, shares = (np.split(arrays[f"loop_{name}"], after) for name in ("ends", "shares"))
    return {
        name: Loop(pairs.astype(np.int64), share.astype(float))
        for name, pairs, share in zip(names, ends, shares, strict=False)  # no loop is one empty part
    }
