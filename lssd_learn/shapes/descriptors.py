"""What tells shapes apart before any map: used for nearest neighbours in the network."""

import numpy as np

from lssd_learn.shapes.eigenbasis import Eigenbasis


def shape_dna(basis: Eigenbasis, unit_area: bool = False) -> np.ndarray:
    """(k,) the eigenvalues of a shape, in 1 / (unit of length)²; its distances are Euclidean.

    Args:
        basis: of the shape.
        unit_area: take them as if the shape had unit area (no unit): without, they mostly tell areas apart.

    Reference:
        Reuter, Wolter and Peinecke, "Laplace–Beltrami spectra as Shape-DNA of surfaces and solids", Computer-Aided
        Design 38 (2006).
    """
    return basis.evals * basis.area if unit_area else basis.evals
