"""A latent space on disk: megabytes of plain arrays, which name the eigenbases they were fitted to."""

import io
import math
import warnings
import zipfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lssd_learn.cache import Cache
from lssd_learn.collections.eigenbases import StoredBases
from lssd_learn.errors import InputError, reading
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.moments import Moments
from lssd_learn.written import write_arrays

VERSION = 1
REFERENCE = "reference/"  # before the name of each
TENSORS = ("Y", "evals", "spectrum", "U", "energy")


def to_state(space) -> dict[str, Tensor | list[str] | str | int]:
    """What a checkpoint keeps of a latent space: tensors, names and the cache keys of its eigenbases."""
    state = {name: getattr(space, name).cpu() for name in TENSORS}
    state |= {
        "version": VERSION,
        "names": list(space.names),
        "keys": [],
        "remedy": "",
        "own": int(space.source is None),
    }
    state |= {f"{REFERENCE}{name}": form.cpu() for name, form in space.references.items()}
    if isinstance(space.bases, StoredBases):
        state |= {"keys": space.bases.keys, "remedy": space.bases.remedy}
    return state


def from_state(kind: type, state: dict, cache: Cache | None = None):
    """A latent space from `to_state`; its eigenbases are looked up in `cache` when first needed."""
    if state.get("version") != VERSION:
        raise InputError(f"latent space: expected format {VERSION}, got {state.get('version')}")
    bases = None
    if state["keys"]:
        names = state["names"] or list(map(str, range(len(state["keys"]))))
        bases = StoredBases(cache or Cache(), state["keys"], names, state["remedy"])
    tensors = {name: state[name] for name in TENSORS}
    references = {key.removeprefix(REFERENCE): state[key] for key in state if key.startswith(REFERENCE)}
    space = kind(**tensors, bases=bases, names=tuple(state["names"]), references=references)
    # Files of before there were references do not say whose average the latent shape is, and then nobody knows.
    return space if state.get("own") else replace(space, source=space.some([]).seen)


def save(space, path: str | Path, bases: bool = False) -> Path:
    """Write a latent space as one `.npz` file; `bases` puts the eigenbases in, so that it is large and stands alone."""
    arrays = {
        name: value.numpy() if isinstance(value, Tensor) else np.array(value) for name, value in to_state(space).items()
    }
    if bases:
        for i in range(len(space)):
            basis = space.eigenbasis(i)
            arrays |= {f"basis/{i}/{name}": np.asarray(getattr(basis, name)) for name in ("evals", "evecs", "mass")}
            arrays[f"basis/{i}/connectivity"] = np.array(basis.connectivity or "")
            if space.references and basis.moments is not None:  # somebody has asked for what is computed of them
                arrays |= {f"basis/{i}/{name}": getattr(basis.moments, name) for name in ("form", "coordinates")}
    return write_arrays(arrays, Path(path))


def load(kind: type, path: str | Path, cache: Cache | None = None):
    """Read what `save` wrote.

    Raises:
        InputError: no such file, or not a latent space.
    """
    path = Path(path)
    if path.suffix == ".ckpt":
        return from_state(kind, _checkpointed(path), cache)
    if not path.is_file():
        raise InputError(f"{path}: no such file; expected a saved latent space (.npz)")
    try:
        arrays = _read_arrays(path)
        state = {name: torch.from_numpy(arrays[name]) for name in TENSORS}
        state |= {name: arrays[name].tolist() for name in ("version", "names", "keys", "remedy")}
        state |= {"own": "own" in arrays and arrays["own"].item()}
        state |= {name: torch.from_numpy(array) for name, array in arrays.items() if name.startswith(REFERENCE)}
    except Exception as error:  # a file that is something else fails in any way
        reason = str(error).splitlines() or [type(error).__name__]
        raise InputError(f"{path}: expected a saved latent space (.npz), but it cannot be read: {reason[0]}") from error
    space = from_state(kind, state, cache)
    if "basis/0/evals" in arrays:
        inside = [_basis(arrays, i) for i in range(len(space))]
        space = replace(space, bases=inside)
    return space


def read_checkpoint(path: str | Path):
    """What torch saved in a file, on the CPU. Tensors and plain containers only are read, so any file may be tried.

    Raises:
        InputError: no such file, or nothing of that kind.
    """
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file; expected a checkpoint")
    with reading(path):
        data = Path(path).read_bytes()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about what is strange in it
            return torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except Exception as error:  # a file that is something else fails in any way, and torch says so at length
        what = "it is damaged, cut off or something else"
        raise InputError(f"{path}: expected a checkpoint, but it cannot be read: {what}") from error


def _read_arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of an .npz that `save` wrote. Nothing is allocated for what a file announces and does not hold."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            with archive.open(member) as stream:
                version = np.lib.format.read_magic(stream)
                read_header = getattr(np.lib.format, f"read_array_header_{version[0]}_0")
                shape, _, dtype = read_header(stream)
            announced = math.prod(shape) * dtype.itemsize
            if announced > member.file_size or member.file_size > path.stat().st_size:  # `save` compresses nothing
                raise ValueError(f"{member.filename} announces {announced:,} bytes")
    with np.load(path, allow_pickle=False) as file:
        return dict(file)


def _checkpointed(path: Path) -> dict:
    content = read_checkpoint(path)
    try:
        return content["latent"]
    except (KeyError, TypeError):
        raise InputError(f"{path}: expected a checkpoint trained on operators, but it holds no latent space") from None


def _basis(arrays: dict[str, np.ndarray], i: int) -> Eigenbasis:
    evals, evecs, mass = (arrays[f"basis/{i}/{name}"] for name in ("evals", "evecs", "mass"))
    measure = None
    if f"basis/{i}/form" in arrays:
        measure = partial(Moments, arrays[f"basis/{i}/form"], arrays[f"basis/{i}/coordinates"])
    return Eigenbasis(evals, evecs, mass, str(arrays[f"basis/{i}/connectivity"]) or None, measure)
