"""Generated faces: several people, each with the same expressions; heads of 4,200 vertices in one connectivity.

Two sets of expressions, happy and sad ones, are what the paper tells apart in its Figure `face`.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from hashlib import blake2b

import numpy as np

from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.body.package import body_package_version
from lssd_learn.collections.generated.expressions import EXPRESSIONS, facial_actions
from lssd_learn.collections.generated.face_model import PARAMETERS, face_model
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh, normalised_area

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other faces: it is part of the cache key


class Faces(Collection):
    """Heads in metres, Z up, looking towards −y, open at the neck; shape i is identity i // e with expression i mod e.

    Args:
        identities: how many people.
        expressions: e of `EXPRESSIONS`, that each of them wears.
        seed: of the parameters of the identities, independent and uniform in [0, 1], and of the strengths. A face does
            not depend on how many others there are, nor on the other expressions.
        weakened: every facial action of every face, left and right by themselves, goes short of the whole by a random
            share from 0 to this: no two smiles are the same.
        normalise_area: scale every head, about the origin, to unit area.

    Attributes:
        parameters: (n, 16) float64 in [0, 1], those of the identity.
        groups: "expression" and "identity".

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        identities: int = 5,
        expressions: Sequence[str] = ("happy", "sad"),
        seed: int = 0,
        weakened: float = 0.3,
        normalise_area: bool = False,
    ):
        check_whole("identities", identities, 1)
        check_whole("seed", seed, 0)
        expressions = [expressions] if isinstance(expressions, str) else list(expressions)
        if not expressions or not set(expressions) <= set(EXPRESSIONS) or len(set(expressions)) < len(expressions):
            got = ", ".join(map(str, expressions)) or "none"
            raise InputError(f"expressions: expected some of {', '.join(EXPRESSIONS)}, each once; got {got}")
        if isinstance(weakened, bool) or not 0 <= weakened <= 1:
            raise InputError(f"weakened: expected a share, 0 to 1, got {weakened!r}")
        self.seed, self.weakened, self.normalise_area = int(seed), float(weakened), bool(normalise_area)
        self._pairs = [(identity, expression) for identity in range(identities) for expression in expressions]
        self.names = [f"face_{identity:02d}_{expression}" for identity, expression in self._pairs]
        self.parameter_names = list(PARAMETERS)
        people = np.random.default_rng(seed).random((identities, len(PARAMETERS)))
        self.parameters = people[[identity for identity, _ in self._pairs]]
        self.parameters.flags.writeable = False
        self.groups = {
            "expression": np.array([expression for _, expression in self._pairs]),
            "identity": np.array([f"face_{identity:02d}" for identity, _ in self._pairs]),
        }
        self.key = self._key([self.shape_key(i) for i in range(len(self))])

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, i: int) -> Mesh:
        return self.make(self.parameters[i], self._actions(*self._pairs[i]))

    def make(self, parameters: Sequence[float] | np.ndarray, expression: str | Mapping[str, float] = "neutral") -> Mesh:
        """One face of one's choice, in the connectivity of the collection.

        Args:
            parameters: (16,) in [0, 1], as `parameter_names`.
            expression: of `EXPRESSIONS`, worn fully; or facial actions of anny and how far each goes, 0 to 1.

        Raises:
            InputError: parameters or actions that do not fit or are out of range, an unknown expression.
        """
        values = np.asarray(parameters, dtype=float)
        if values.shape != (len(PARAMETERS),) or not ((values >= 0) & (values <= 1)).all():
            raise InputError(f"parameters: expected {len(PARAMETERS)} values in [0, 1], got {parameters!r}")
        if isinstance(expression, str) and expression not in EXPRESSIONS:
            raise InputError(f"expression: expected one of {', '.join(EXPRESSIONS)}, got {expression!r}")
        actions = facial_actions(expression) if isinstance(expression, str) else dict(expression)
        model = face_model()
        for name, value in actions.items():
            if name not in model.actions:
                raise InputError(f"expression: expected actions of {', '.join(model.actions)}, got {name!r}")
            if not 0 <= value <= 1:
                raise InputError(f"expression: expected {name} in [0, 1], got {value!r}")
        vertices = model.vertices(dict(zip(PARAMETERS, values.tolist(), strict=True)), actions)
        mesh = Mesh(vertices, model.faces)
        return normalised_area(mesh) if self.normalise_area else mesh

    @property
    def landmarks(self) -> list[dict[str, int]]:
        """Sixteen places on a face, the same vertex on each; loads the model."""
        return [dict(face_model().landmarks)] * len(self)

    def shape_key(self, i: int) -> str:
        """Does not depend on how many identities and expressions there are."""
        return self._shape_keys[i]

    @cached_property
    def _shape_keys(self) -> list[str]:
        return [
            self._key([self.parameters[i].tolist(), self._actions(*pair), self.normalise_area])
            for i, pair in enumerate(self._pairs)
        ]

    def _actions(self, identity: int, expression: str) -> dict[str, float]:
        """An expression as this person wears it."""
        actions = facial_actions(expression)
        rng = np.random.default_rng([self.seed, identity, list(EXPRESSIONS).index(expression)])
        strengths = 1 - self.weakened * rng.random(len(actions))
        return {name: value * float(s) for (name, value), s in zip(actions.items(), strengths, strict=True)}

    def _key(self, content) -> str:
        whole = repr(("Faces", GENERATOR_VERSION, body_package_version(), content))
        return blake2b(whole.encode(), digest_size=16).hexdigest()
