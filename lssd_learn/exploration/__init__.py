"""What the operators tell about a collection."""

from lssd_learn.exploration.align import Alignment, align, descriptors
from lssd_learn.exploration.base_shape import adjoint_energy, base_shape_differences
from lssd_learn.exploration.embed import Embedding, embed, pca
from lssd_learn.exploration.evidence import evidence, evidence_stability, local_evidence
from lssd_learn.exploration.pairs import PairEnergies, pair_energies
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.separation import (
    PermutationTest,
    held_out_accuracy,
    nearest_accuracy,
    permutation_test,
    silhouette,
)
from lssd_learn.exploration.stability import change_of_basis, off_band, principal_angles
from lssd_learn.exploration.variability import cross_collection, global_variability, highlighted, within_group

__all__ = [
    "Alignment",
    "Embedding",
    "PairEnergies",
    "PermutationTest",
    "adjoint_energy",
    "align",
    "base_shape_differences",
    "change_of_basis",
    "cross_collection",
    "descriptors",
    "embed",
    "evidence",
    "evidence_stability",
    "global_variability",
    "held_out_accuracy",
    "highlighted",
    "local_evidence",
    "nearest_accuracy",
    "off_band",
    "pair_energies",
    "pca",
    "permutation_test",
    "principal_angles",
    "representatives",
    "silhouette",
    "within_group",
]
