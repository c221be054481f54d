"""The parametric body behind `../bodies.py`: loads anny's model and evaluates it, one body at a time.

With `face_model.py`, the only file of the collections that imports torch, and only when a model is loaded: anny needs
it.
"""

import contextlib
import logging
import os
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from lssd_learn.collections.generated.body.cache import guarded
from lssd_learn.collections.generated.body.further import FURTHER_CHANGES
from lssd_learn.collections.generated.body.poses import Angles, bone_rotations
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, clean

log = logging.getLogger(__name__)

# Each gives a closed surface of one component. The others that anny knows need a download under another licence,
# or are these with other gaps and helpers.
TOPOLOGIES = ("notoes", "notoes_collapse10pc", "notoes_collapse5pc", "notoes_collapse3pc", "anny")

# Our parameters that anny calls local changes; the others have the same name there. It builds and keeps hundreds of
# megabytes a list of them, order included, so there are two lists for bodies: these, and with `FURTHER_CHANGES`.
LOCAL_CHANGES = {
    "waist": "measure-waist-circ-incr",
    "hips": "measure-hips-circ-incr",
    "thigh": "measure-thigh-circ-incr",
    "calf": "measure-calf-circ-incr",
    "upper_arm": "measure-upperarm-circ-incr",
    "bust": "measure-bust-circ-incr",
    "belly": "stomach-pregnant-incr",
    "torso_v_shape": "torso-vshape-incr",
    "upper_leg_length": "measure-upperleg-height-incr",
}

# What the parameters leave open: a grown-up halfway between female and male.
FIXED = {"age": 0.67, "gender": 0.5, "proportions": 0.5}


class BodyModel:
    """anny's model of one topology, restricted to its largest connected component.

    Args:
        topology: one of `TOPOLOGIES`.
        further: whether parameters may be `FURTHER_CHANGES` too.

    Attributes:
        faces: (F, 3) int64, the same for every body, oriented outward.
        bones: names of the B bones.
        parents: the bone that each hangs from, −1 of the first.
        bone_weights: (V, B) float64, how much each vertex follows each bone; rows sum to 1.
        left: (V,) bool, the left half of the template.
    """

    def __init__(self, topology: str, further: bool = False):
        self._changes = {name: (change,) for name, change in LOCAL_CHANGES.items()}
        if further:
            self._changes |= FURTHER_CHANGES
        self._model = load_anny(topology, [change for changes in self._changes.values() for change in changes])
        template = Mesh(self._model.template_vertices.numpy(), self._model.get_triangular_faces().numpy())
        whole = clean(template, f"body template {topology}")
        self.faces = whole.mesh.faces
        self.bones = list(self._model.bone_labels)
        self.parents = [int(bone) for bone in self._model.bone_parents]
        self._kept = whole.vertex_index
        self.bone_weights = self._model.dense_vertex_bone_weights.numpy()[self._kept]
        self.left = template.vertices[self._kept, 0] > 0

    def vertices(
        self,
        parameters: Mapping[str, float],
        pose: str | int | Angles,
        offsets: np.ndarray | None = None,
        moved: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> np.ndarray:
        """(V, 3) float64 vertices in metres, Z up, of the body with these parameters in [0, 1]; .5 is neutral.

        `offsets` are added to the angles of the pose, see `bone_rotations`; what `moved` makes of the vertices at rest
        (V, 3) is added to these before they are posed.

        Raises:
            InputError: a pose of bones that there are not.
        """
        return self._evaluate(parameters, bone_rotations(pose, offsets), moved)["vertices"][0].numpy()[self._kept]

    def rest(self, parameters: Mapping[str, float]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """(V, 3) vertices of a body as `vertices` has it in the rest pose, but for where it stands, and bone → (3,) the
        head of each bone in it."""
        found = self._evaluate(parameters, {})
        heads = found["rest_bone_heads"][0].numpy()
        return found["rest_vertices"][0].numpy()[self._kept], dict(zip(self.bones, heads, strict=True))

    def joints_of(self, parameters: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(V, 3) vertices of a body at rest, and (B, 4, 4) where each bone lies there, and in a pose of no angles."""
        found = self._evaluate(parameters, {})
        resting, turned = (found[name][0].numpy() for name in ("rest_bone_poses", "bone_poses"))
        return found["rest_vertices"][0].numpy()[self._kept], resting, turned

    def inverted(self, points: np.ndarray) -> tuple[dict[str, float], np.ndarray]:
        """The sliders of a person whose vertices lie nearest to points (V, 3), metres, and (V, 3) where these then lie.

        By anny's own `AnnyInverter`, which finds poses and all sliders but the local changes, from a thousand vertices.
        """
        import anny
        import torch

        whole = self._model.template_vertices.clone()
        whole[self._kept] = torch.tensor(points, dtype=whole.dtype)
        before = torch.get_default_dtype()
        torch.set_default_dtype(torch.float64)  # which the inverter takes for granted that its model has
        try:
            inverter = anny.AnnyInverter(self._model, n_points=1000)
            inverter.dtype, inverter.reg_weights = self._model.dtype, inverter.reg_weights.to(self._model.dtype)
            _, sliders, lying = inverter(whole)
        finally:
            torch.set_default_dtype(before)
        return {name: float(value) for name, value in sliders.items()}, lying[0].numpy()[self._kept]

    def _evaluate(
        self,
        parameters: Mapping[str, float],
        rotations: Mapping[str, np.ndarray],
        moved: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> dict:
        """What anny says of one body."""
        import torch

        transforms = torch.eye(4, dtype=self._model.dtype).repeat(1, len(self.bones), 1, 1)
        for bone, rotation in rotations.items():
            if bone not in self.bones:
                raise InputError(f"pose: expected bones of the body model, such as {self.bones[1]}, got {bone!r}")
            transforms[0, self.bones.index(bone), :3, :3] = torch.from_numpy(rotation)
        phenotypes = FIXED | {name: p for name, p in parameters.items() if name not in self._changes}
        changes = {change: 2 * p - 1 for name, p in parameters.items() for change in self._changes.get(name, ())}
        threads = torch.get_num_threads()
        torch.set_num_threads(1)  # the same bits on any number of cores, and no slower
        try:
            with torch.no_grad():
                out = self._model(transforms, phenotypes, changes, pose_parameterization="local-ref")
                if moved is not None:
                    rest = out["rest_vertices"].clone()
                    rest[0, self._kept] += torch.from_numpy(moved(rest[0].numpy()[self._kept])).to(rest)
                    bones, _ = self._model.get_bone_transforms(transforms, out["rest_bone_poses"], "local-ref")
                    out["vertices"] = self._model.get_skinned_vertices(bone_transforms=bones, rest_vertices=rest)
                return out
        finally:
            torch.set_num_threads(threads)


def body_model(topology: str, further: bool = False) -> BodyModel:
    """The model of one of `TOPOLOGIES`, loaded once a process (seconds; a minute the very first time)."""
    return _loaded(topology, bool(further))


@cache
def _loaded(topology: str, further: bool) -> BodyModel:
    start = time.perf_counter()
    model = BodyModel(topology, further)
    log.debug("body model %s loaded in %.1f s", topology, time.perf_counter() - start)
    return model


def load_anny(topology: str, local_changes: Sequence[str], **options):
    """anny's model of a topology with some of its local changes, built if nobody has built it before.

    What all models share, most of the time and half a gigabyte, is built once, by whichever comes first.

    Args:
        topology: of anny.
        local_changes: their names there.
        options: further ones of `anny.Anny`.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import anny
        from anny.paths import get_anny_cache_path, set_anny_cache_path

        folder = Path(get_anny_cache_path())
        with guarded(folder) as staging, _announce_building():
            set_anny_cache_path(staging)
            try:
                # Plain linear blend skinning: the default compiles a kernel, and its sums depend on the device.
                return anny.Anny(topology=topology, local_changes=list(local_changes), skinning_method="lbs", **options)
            finally:
                set_anny_cache_path(folder)


class _Builder(logging.Handler):
    """Acts on anny's own message that it found no cached model: says so once, and hushes what it builds with."""

    said = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self.said and record.getMessage().startswith("No cached model data"):
            self.said = True
            log.info("building the body model, about a minute, once")
            _hush_warp()


@contextlib.contextmanager
def _announce_building() -> Iterator[None]:
    logger = logging.getLogger("anny")
    level, propagate, handler = logger.level, logger.propagate, _Builder(logging.INFO)
    logger.setLevel(logging.INFO)
    logger.propagate = False
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = propagate


def _hush_warp() -> None:
    """Keep warp quiet. Its compiled part warns of a missing GPU past Python's own streams, so those are turned off."""
    import warp

    warp.config.quiet = True  # pyright: ignore[reportAttributeAccessIssue] of older versions
    warp.config.log_level = getattr(warp, "LOG_ERROR", 40)
    stderr = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        warp.init()
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
