"""Measures read off clouds by a PointNet that has been trained on people turned at random."""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.collections import People
from lssd_learn.models.measuring.units import find_unit, in_metres
from lssd_learn.nets.pointnet import PointNet
from lssd_learn.progress import track
from lssd_learn.shapes import Shape
from lssd_learn.shapes.sampling import sample

POINTS, BATCH, RATE = 1024, 32, 1e-3
TOPOLOGY = "notoes_collapse10pc"  # of the people it is trained on
SEED = 900
FURTHER = 0.15  # that of collection=remeshed_people


def read_by_net(shapes: Sequence[Shape], people: int, epochs: int) -> Float[np.ndarray, "n p"]:
    """(n, p) measures of scans, by the paper's PointNet, variant B, on 1,024 points about their centre.

    Args:
        people: that it is trained on, turned otherwise in every epoch.
        epochs: with a learning rate that falls to zero along a cosine.
    """
    torch.manual_seed(SEED)
    rng = np.random.default_rng(SEED)
    known = People(people, seed=SEED, topology=TOPOLOGY, further=FURTHER)
    clouds = np.stack([_centred(shape, rng) for shape in track(list(known), "clouds")])
    goals = np.log(known.parameters)
    mean, deviation = goals.mean(axis=0), goals.std(axis=0)
    wanted = torch.tensor((goals - mean) / deviation, dtype=torch.float32)
    net = PointNet(3, POINTS, goals.shape[1])
    rounds = epochs * -(-people // BATCH)
    optimiser = torch.optim.Adam(net.parameters(), RATE)
    falling = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, rounds)
    for _ in track(list(range(epochs)), "PointNet"):
        for some in np.array_split(rng.permutation(people), -(-people // BATCH)):
            turns = Rotation.from_quat(rng.standard_normal((len(some), 4))).as_matrix()
            turned = torch.tensor(clouds[some] @ turns, dtype=torch.float32)
            loss = torch.square(net(turned) - wanted[some]).mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            falling.step()
    asked = np.stack([_centred(in_metres(shape, find_unit(shape)), rng) for shape in shapes])
    with torch.no_grad():
        read = net(torch.tensor(asked, dtype=torch.float32)).double().numpy()
    return np.exp(mean + deviation * read)


def _centred(shape: Shape, rng: np.random.Generator) -> np.ndarray:
    points = sample(shape, POINTS, rng)
    return points - points.mean(axis=0)
