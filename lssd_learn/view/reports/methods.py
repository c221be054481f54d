"""What a run did, as a paragraph for a paper with the run's own numbers, and the papers behind it."""

from collections.abc import Sequence
from dataclasses import dataclass

import lssd_learn
from lssd_learn.collections.checked import ensure_checked
from lssd_learn.partials import unbound
from lssd_learn.pipeline import Pipeline
from lssd_learn.view.reports.blocks import folded, listed

CITED = {
    "differences": "Rustamov, Ovsjanikov, Azencot, Ben-Chen, Chazal & Guibas. Map-based exploration of intrinsic shape "
    "differences and variability. ACM Transactions on Graphics 32 (2013).",
    "latent": "Huang, Achlioptas, Guibas & Ovsjanikov. Limit shapes: a tool for understanding shape differences and "
    "variability in 3D model collections. Computer Graphics Forum 38 (2019); Latent space representation for shape "
    "analysis and learning. arXiv 1806.03967 (2018).",
    "maps": "Ovsjanikov, Ben-Chen, Solomon, Butscher & Guibas. Functional maps: a flexible representation of maps "
    "between shapes. ACM Transactions on Graphics 31 (2012).",
    "logarithms": "Arsigny, Fillard, Pennec & Ayache. Geometric means in a novel vector space structure on symmetric "
    "positive-definite matrices. SIAM Journal on Matrix Analysis and Applications 29 (2007).",
    "rrpp": "Collyer, Sekora & Adams. A method for analysis of phenotypic change for phenotypes described by "
    "high-dimensional data. Heredity 115 (2015).",
    "residuals": "Freedman & Lane. A nonstochastic interpretation of reported significance levels. Journal of Business "
    "& "
    "Economic Statistics 1 (1983).",
    "blocks": "Winkler, Webster, Vidaurre, Nichols & Smith. Multi-level block permutation. NeuroImage 123 (2015).",
    "largest": "Nichols & Holmes. Nonparametric permutation tests for functional neuroimaging. Human Brain Mapping 15 "
    "(2002).",
    "procrustes": "Gower. Generalized Procrustes analysis. Psychometrika 40 (1975).",
}


@dataclass(frozen=True)
class Latent:
    """How the latent space of a run was made.

    Attributes:
        shapes: in the collection.
        k, size, keep: eigenfunctions a shape, consistent functions, those that were kept.
        network: the topology, such as "clique".
        maps: what maps were computed by; None where vertices correspond.
        kinds: of operators.
        told: what was said of the shapes when they were read.
    """

    shapes: int
    k: int
    size: int
    keep: int
    network: str
    maps: str | None
    kinds: Sequence[str]
    told: Sequence[str] = ()

    @classmethod
    def of(cls, pipeline: Pipeline, network: str, kinds: Sequence[str]) -> "Latent":
        """Of a pipeline whose latent space is there.

        Args:
            network: what the topology is called.
            kinds: of operators.
        """
        maps = None if pipeline.pair_maps().is_identity else getattr(unbound(pipeline.maps), "__name__", "given")
        size, keep = pipeline.size, pipeline.keep
        told = ensure_checked(pipeline.collection, pipeline.cache)
        return cls(len(pipeline.collection), pipeline.k, size, keep, network, maps, kinds, told)

    def read(self) -> str:
        """What was mended, cut away, left out or guessed, to be unfolded; "" where nothing was."""
        return folded("How the shapes were read", listed(self.told)) if self.told else ""

    def words(self) -> str:
        """Two or three sentences."""
        how = (
            "by the identity of vertices, which correspond one to one,"
            if self.maps is None
            else f"computed between shapes (method “{self.maps}”)"
        )
        kinds = " and ".join(self.kinds)
        return (
            f"{self.shapes} shapes were compared by latent space shape differences (Rustamov et al. 2013; Huang et al. "
            f"2018, 2019) with lssd_learn {lssd_learn.__version__}. The first {self.k} eigenfunctions of the Laplacian "
            f"of each shape and functional maps (Ovsjanikov et al. 2012) {how} along a network of the topology "
            f"“{self.network}” gave a latent shape with {self.size} consistent functions, of which the {self.keep} of "
            f"lowest frequency were kept. Each shape is then described by its {kinds} difference from the latent "
            f"shape, "
            f"a symmetric matrix of {self.keep} × {self.keep} numbers{' each' if len(self.kinds) > 1 else ''}."
        )


def chance(permutations: int, exact: bool) -> str:
    """How often labels or residuals were permuted, the data as they are among these."""
    return f"all {permutations:,} permutations" if exact else f"{permutations:,} permutations (the data among them)"


def p_value(p: float) -> str:
    """Such as ".04" or "< .001" by three digits at most."""
    return "< .001" if p < 0.001 else f"= {p:.2g}".replace("0.", ".")


def references(keys: Sequence[str]) -> list[str]:
    """Of `CITED`, by the alphabet."""
    return sorted(CITED[key] for key in keys)
