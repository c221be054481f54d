"""Many maps: the network, its consistent and canonical latent bases, the differences, shapes pushed in later."""

from lssd_learn.latent.basis import ConsistentBasis, canonical_basis, consistent_basis
from lssd_learn.latent.differences import area_difference, conformal_difference, pseudo_inverse
from lssd_learn.latent.explicit import ExplicitForm
from lssd_learn.latent.extrinsic import extrinsic_difference, gram, latent_coordinates, smooth_embedding
from lssd_learn.latent.factorised import FactorisedForm
from lssd_learn.latent.factors import Factors, compressed_factors, exact_factors
from lssd_learn.latent.network import MapNetwork
from lssd_learn.latent.newcomers import push_all
from lssd_learn.latent.push import push_least_squares, push_nearest
from lssd_learn.latent.region import Region, find_region
from lssd_learn.latent.space import LatentSpace, Pushed

__all__ = [
    "ConsistentBasis",
    "ExplicitForm",
    "FactorisedForm",
    "Factors",
    "LatentSpace",
    "MapNetwork",
    "Pushed",
    "Region",
    "area_difference",
    "canonical_basis",
    "compressed_factors",
    "conformal_difference",
    "consistent_basis",
    "exact_factors",
    "extrinsic_difference",
    "find_region",
    "gram",
    "latent_coordinates",
    "pseudo_inverse",
    "push_all",
    "push_least_squares",
    "push_nearest",
    "smooth_embedding",
]
