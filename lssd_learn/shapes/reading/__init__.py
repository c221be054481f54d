"""What a file of a shape says, format by format: bytes in, vertices and faces out. Called by `files.load`.

Every reader takes the whole file or refuses it with a `ValueError` of one line; what it leaves out on purpose, or
takes a guess at, is in the notes.
"""

from lssd_learn.shapes.reading import glb, obj, off, ply, stl, vtk, vtp, xyz
from lssd_learn.shapes.reading.parsed import Parsed
from lssd_learn.shapes.reading.words import space_of, what_it_is

__all__ = ["READERS", "Parsed", "space_of", "what_it_is"]

READERS = {
    ".off": off.read,
    ".obj": obj.read,
    ".ply": ply.read,
    ".stl": stl.read,
    ".glb": glb.read,
    ".vtk": vtk.read,
    ".vtp": vtp.read,
    ".xyz": xyz.read,
}
