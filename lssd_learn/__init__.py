"""Latent space shape differences (LSSDs): every shape of a collection as a pair of small matrices, without a template.

    shapes → eigenbases → functional map network → latent space → LSSDs → learn · explore · synthesise

After "Latent Space Representation for Shape Analysis and Learning" (Huang, Achlioptas, Guibas, Ovsjanikov).

The paper's letters, as they stand in formulas and local code:

    V, F        vertices (V, 3) and faces (F, 3); V is also their number
    L, M        stiffness (positive semi-definite) and lumped mass; the Laplacian is M⁻¹L
    Λ, Φ        its lowest k eigenvalues and eigenfunctions, ΦᵀMΦ = I
    C_ij        functional map, carries functions on shape i to functions on shape j
    w_ij, W     weights of the network, its energy as a quadratic form
    Y_i         latent basis on shape i, in its eigenfunctions; Σ Y_iᵀY_i = n·I
    Λ₀, U       spectrum of the latent shape, rotation to the canonical basis
    D^A, D^C    area and conformal difference, YᵀY and Λ₀⁺YᵀΛY
    α           a function on the latent shape
"""

import sys
from importlib import import_module

# name → where it lives; loaded when first asked for
_PUBLIC = {
    "Cache": "cache",
    "Eigenbasis": "shapes",
    "InputError": "errors",
    "LSSD": "estimator",
    "LatentSpace": "latent",
    "MapNetwork": "latent",
    "Mesh": "shapes",
    "Pipeline": "pipeline",
    "PointCloud": "shapes",
    "chamfer": "nets",
    "eigenbases": "collections",
    "eigenbasis": "shapes",
    "load": "shapes",
    "save": "shapes",
}
_ROOMS = ("collections", "exploration", "latent", "learning", "maps", "models", "nets", "operators", "shapes", "view")

__all__ = ["__version__", *_PUBLIC, *_ROOMS]


def __getattr__(name: str):
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name in _PUBLIC:
        return getattr(import_module(f"{__name__}.{_PUBLIC[name]}"), name)
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


if "IPython" in sys.modules:  # a notebook, where shapes and spaces are shown as pictures
    import_module(f"{__name__}.jupyter").register()
