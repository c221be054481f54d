"""Many shapes: generated ones and a folder of one's own. Free of torch until a body model is loaded."""

from lssd_learn.collections.aligned import Aligned, AlignedFolder
from lssd_learn.collections.base import Collection, ShapeList
from lssd_learn.collections.benchmark import Benchmark
from lssd_learn.collections.clouds import clouds
from lssd_learn.collections.eigenbases import StoredBases, eigenbases
from lssd_learn.collections.folder import Folder
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.collections.generated.bumps import Bumps
from lssd_learn.collections.generated.changed import Changed
from lssd_learn.collections.generated.characters import Characters
from lssd_learn.collections.generated.faces import Faces
from lssd_learn.collections.generated.faulty import Faulty
from lssd_learn.collections.generated.grown import Grown
from lssd_learn.collections.generated.mixed import Mixed
from lssd_learn.collections.generated.motion import Motion
from lssd_learn.collections.generated.people import People
from lssd_learn.collections.generated.remeshed import Remeshed
from lssd_learn.collections.generated.walled import Walled
from lssd_learn.collections.given import AtHand, as_collection
from lssd_learn.collections.previews import previews
from lssd_learn.collections.subset import Subset

__all__ = [
    "POSE_NAMES",
    "Aligned",
    "AlignedFolder",
    "AtHand",
    "Benchmark",
    "Bodies",
    "Bumps",
    "Changed",
    "Characters",
    "Collection",
    "Faces",
    "Faulty",
    "Folder",
    "Grown",
    "Mixed",
    "Motion",
    "People",
    "Remeshed",
    "ShapeList",
    "StoredBases",
    "Subset",
    "Walled",
    "as_collection",
    "clouds",
    "eigenbases",
    "previews",
]
