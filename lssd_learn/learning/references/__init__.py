"""What a net has to beat: answers in closed form, from the mean of the training shapes to ridge regressions."""

from lssd_learn.learning.references.classes import ClassReference, linear_reference, majority_reference
from lssd_learn.learning.references.parameters import Reference, mean_reference, operator_features, ridge_reference

__all__ = [
    "ClassReference",
    "Reference",
    "linear_reference",
    "majority_reference",
    "mean_reference",
    "operator_features",
    "ridge_reference",
]
