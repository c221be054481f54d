"""What the log says of an alignment: what was done, and all that was not clear."""

import logging
from collections.abc import Sequence

import numpy as np

from lssd_learn.collections.alignment.lie import ALIKE, UNLIKE, Lie
from lssd_learn.errors import some_of
from lssd_learn.shapes.closest_points import angles
from lssd_learn.shapes.rigid import FLOOR, TIE

log = logging.getLogger(__name__)

NAMED = 8  # shapes named in a warning


def tell(lie: Lie, names: Sequence[str], mirror: str) -> None:
    """Say what was done, and warn of all that was not clear."""
    why = str(lie.left)
    if np.isnan(lie.residual).all():
        log.info("shapes are left as they lie%s", f": {why}" if why else "")
        return

    def some(which: np.ndarray) -> str:
        return some_of([names[i] for i in np.flatnonzero(which).tolist()], NAMED)

    residual = float(np.median(lie.residual))
    if residual > UNLIKE:
        log.warning(
            "alignment: no turn lays these shapes on each other, what is left is %.2f of their size (bones of one "
            "kind: below %.2f); they bend at joints, or are of several kinds%s",
            residual, UNLIKE, ", and are left as they lie" if why else "",
        )  # fmt: skip
    if why:
        return
    log.info(
        "alignment: turned by up to %.0f°, %d of %d mirrored%s; what is left is %.3f of their size",
        angles(lie.rotation).max(), lie.mirrored.sum(), len(names),
        f" ({some(lie.mirrored)})" if lie.mirrored.any() else "", residual,
    )  # fmt: skip
    if not lie.fits.all():
        log.warning("alignment: of another kind than most, or badly laid: %s", some(~lie.fits))
    if residual > UNLIKE:
        return  # whatever else there is to tell would be said of all
    if lie.partial.any():
        shares = ", ".join(f"{share:.0%}" for share in lie.missing[lie.partial][:NAMED])
        log.warning("alignment: a part seems to be missing of %s (%s)", some(lie.partial), shares)
    near = TIE * np.maximum(lie.residual, FLOOR)
    tied = lie.fits & (lie.other < near)
    if mirror != "forbid" and tied.any():
        log.warning(
            "alignment: which side shapes are of is not told, mirrored they fit as well (%.3f and %.3f of the size): "
            "%s; %s",
            np.median(lie.residual[tied]), np.median(lie.other[tied]), some(tied),
            "the better side was taken" if mirror == "allow" else "left on the side they lie",
        )  # fmt: skip
    turning = lie.fits & (lie.rival < near)
    if turning.any():
        log.warning("alignment: another turn fits as well, the one taken is a guess: %s", some(turning))
    apart = lie.fits & (lie.off > ALIKE)
    if apart.any():
        log.warning("alignment: pairs disagree by more than %.0f° about %s", ALIKE, some(apart))
