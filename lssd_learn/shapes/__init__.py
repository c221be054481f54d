"""One shape: mesh and point cloud, reading, checking, Laplacian, eigenbasis, sampling, descriptors."""

from lssd_learn.shapes.average import average_eigenbasis
from lssd_learn.shapes.clean import Cleaned, clean, is_fit_for_cotangent, keep, mend
from lssd_learn.shapes.descriptors import shape_dna
from lssd_learn.shapes.eigenbasis import Eigenbasis, eigenbasis
from lssd_learn.shapes.files import FORMATS, Reading, load, read, save
from lssd_learn.shapes.given import as_shape
from lssd_learn.shapes.laplacian import cotangent, laplacian, normalised_area, robust
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape
from lssd_learn.shapes.sampling import sample

__all__ = [
    "FORMATS",
    "Cleaned",
    "Eigenbasis",
    "Mesh",
    "PointCloud",
    "Reading",
    "Shape",
    "as_shape",
    "average_eigenbasis",
    "clean",
    "cotangent",
    "eigenbasis",
    "is_fit_for_cotangent",
    "keep",
    "laplacian",
    "load",
    "mend",
    "normalised_area",
    "read",
    "robust",
    "sample",
    "save",
    "shape_dna",
]
