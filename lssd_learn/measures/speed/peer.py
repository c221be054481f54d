"""What `task=benchmark` compares with: pyfmaps (github.com/RobinMagnet/pyFM), and a bare loop in PyTorch.

Work for the stopwatch, like `timed.py`. The peer gets its best case: what it can hold ready is ready before the clock
starts, and each map is one product of matrices.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np

from lssd_learn.measures.speed.timed import spectra


def is_installed() -> bool:
    """Is pyfmaps there?"""
    return find_spec("pyFM") is not None


def eigenbases(shapes: Sequence, k: int):
    """The eigenbasis of each mesh, Laplacian included; a lap a mesh."""
    from pyFM.mesh import TriMesh

    TriMesh(shapes[-1].vertices, shapes[-1].faces).process(k=k)
    for i, mesh in enumerate(shapes):
        yield f"shape {i}"
        TriMesh(mesh.vertices, mesh.faces).process(k=k)
    yield None


def latent(bases: Sequence, size: int, keep: int):
    """All n² maps of vertex identity, the consistent and the canonical basis, the operators of all shapes.

    Returns:
        see `timed.spectra`.
    """
    from pyFM.FMN import FMN

    k = len(bases[0].evals)
    evecs = [np.asarray(basis.evecs, dtype=float) for basis in bases]
    # The network copies its meshes and of their eigenfunctions looks at no more than the number.
    meshes = [SimpleNamespace(eigenvalues=np.array(b.evals), eigenvectors=np.empty((0, k))) for b in bases]
    _fit(FMN(meshes[:2]), {(i, j): np.eye(k) for i, j in ((0, 1), (1, 0))}, k, size, keep)
    network = FMN(meshes)
    yield "maps"
    maps = {}
    for j, basis in enumerate(bases):
        weighted = evecs[j].T * basis.mass
        maps |= {(i, j): weighted @ Phi for i, Phi in enumerate(evecs) if i != j}
    yield "basis"
    _fit(network, maps, k, size, keep)
    yield "operators"
    area, conformal = (np.stack(D) for D in zip(*map(network.get_CSD, range(len(bases))), strict=True))
    yield None
    return spectra(area, conformal)


def _fit(network, maps: dict, k: int, size: int, keep: int) -> None:
    """The canonical basis of a network without maps as yet: `size` functions made canonical, `keep` kept."""
    network.set_maps(maps).set_weights(weight_type="adjacency")
    network.compute_W(M=k)
    network.compute_CLB()
    network.compute_CCLB(size, verbose=False)
    network.CCLB, network.cclb_eigenvalues = network.CCLB[:, :, :keep], network.cclb_eigenvalues[:keep]


def training(net: Callable, parts: dict, batches: Sequence, learning_rate: float, seed: int):
    """What `timed.training` does, bare: the same net, batches and choice of the epoch; nothing logged, nothing saved.

    Args:
        net: the class of a net or a partial of it.
        parts: "train" and "validation" → (inputs, targets) tensors; "mean", subtracted from the inputs; "shape", the
            net's arguments.
        batches: an epoch each, the positions (b,) of every batch.

    Returns:
        the validation error of the chosen epoch.
    """
    import torch
    from torch.nn.functional import mse_loss

    (inputs, targets), (others, wanted), mean = parts["train"], parts["validation"], parts["mean"]

    @torch.random.fork_rng(devices=())
    def loop(epochs: Sequence) -> float:
        torch.manual_seed(seed)
        model = net(**parts["shape"])
        optimizer = torch.optim.Adam(model.parameters(), lr=learning_rate, fused=True)
        lowest, best = float("inf"), None
        for epoch in epochs:
            model.train()
            for batch in epoch:
                optimizer.zero_grad()
                mse_loss(model(inputs[batch] - mean), targets[batch]).backward()
                optimizer.step()
            model.eval()
            with torch.no_grad():
                error = float(mse_loss(model(others - mean), wanted))
            if error < lowest:
                lowest, best = error, deepcopy(model.state_dict())
        model.load_state_dict(best)
        return lowest

    loop(batches[:1])
    yield "loop"
    lowest = loop(batches)
    yield None
    return lowest
