"""Algebra on the small matrices: suppress a region, mix two shapes, walk between them, answer analogies; gradients."""

from lssd_learn.differentiable import vertex_operators
from lssd_learn.operators.analogies import analogy
from lssd_learn.operators.blending import blend
from lssd_learn.operators.embeddings import shapes_of_gram
from lssd_learn.operators.interpolation import interpolate
from lssd_learn.operators.inversion import functions_of, shape_of_operators
from lssd_learn.operators.localisation import localise
from lssd_learn.operators.logarithms import exponential, log_eigenvalues, logarithm
from lssd_learn.operators.matrices import null_functions
from lssd_learn.operators.projection import delta_energy, project
from lssd_learn.operators.rigidity import moved_alike, with_turned_detail

__all__ = [
    "analogy",
    "blend",
    "delta_energy",
    "exponential",
    "functions_of",
    "interpolate",
    "localise",
    "log_eigenvalues",
    "logarithm",
    "moved_alike",
    "null_functions",
    "project",
    "shape_of_operators",
    "shapes_of_gram",
    "vertex_operators",
    "with_turned_detail",
]
