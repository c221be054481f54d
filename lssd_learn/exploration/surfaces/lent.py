"""Surfaces at coordinates on the latent shape, drawn on the mesh of one shape, which lends its detail."""

from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float

from lssd_learn.exploration.surfaces.coordinates import Coordinates
from lssd_learn.latent import LatentSpace
from lssd_learn.shapes import Mesh, Shape


@dataclass(frozen=True, eq=False)
class Lender:
    """The shape on whose mesh surfaces are drawn.

    A surface is x_i + Φ_iY_i(x̂ − x̂_i): smooth as m functions are in how it differs from the shape, and what is finer
    than these, edges, pores, fingers, is that of the shape, neither turned nor scaled. At x̂_i it is the shape itself.

    Attributes:
        shape: V vertices.
        functions: Φ_iY_i (V, m), the latent functions at its vertices.
        x: x̂_i (m, 3), its own coordinates.
    """

    shape: Shape
    functions: Float[np.ndarray, "V m"]
    x: Float[np.ndarray, "m 3"]

    @classmethod
    def of(cls, latent: LatentSpace, found: Coordinates, shape: Shape) -> "Lender":
        """The base of coordinates.

        Args:
            latent: the space they are of.
            found: the coordinates.
            shape: their base, as it lies.
        """
        functions = latent.to_shape(torch.eye(latent.keep), found.base).cpu().numpy()
        return cls(shape, functions, found.x[found.base])

    def vertices(self, x: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "V 3"]:
        """(V, 3) of the surface at coordinates."""
        return self.shape.vertices + self.functions @ (x - self.x)

    def surface(self, x: Float[np.ndarray, "m 3"]) -> Shape:
        """The same as a shape."""
        points = self.vertices(x)
        return Mesh(points, self.shape.faces) if isinstance(self.shape, Mesh) else replace(self.shape, points=points)
