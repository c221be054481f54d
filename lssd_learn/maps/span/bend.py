"""The mixture of known shapes that lies on a new one once it is bent: people hold their limbs as none of the known do.

What a mixture cannot follow, a turn at a joint, bending can, and what bending must not, a limb of another length or
girth, the mixture can: both are found together, so that neither does the other's part.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.span.fit import CLOSE, FAR, NORMALS, POINTS, ROUGH, Surface
from lssd_learn.maps.span.net import Net
from lssd_learn.maps.span.span import Span
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import nearest_rotation
from lssd_learn.shapes.normals import normals

FIRST = 4  # rounds towards the places
STIFFNESS = np.geomspace(3.0, 1.0, 20)  # of each round after these: mean square change of edges, against distances
JOINT = 0.0015  # change of an edge, over √area, beyond which it hardly costs more: joints are few, and bend freely
SURE = CLOSE / 4  # as `CLOSE`: modes that were held back more would be made up for by bending
BACK = 1500  # points of the surface that are matched in a round


@dataclass(frozen=True, eq=False)
class Bend:
    """A mixture, bent.

    Attributes:
        weights: (r,) of the modes.
        turns: (n, 3, 3) of the knots of a net, and
        places: (n, 3) where they lie.
    """

    weights: Float[np.ndarray, " r"]
    turns: Float[np.ndarray, "n 3 3"]
    places: Float[np.ndarray, "n 3"]


def bent(
    of: Span, mesh: Mesh, on: Net, places: Float[np.ndarray, "V 3"], onto: Surface
) -> tuple[Float[np.ndarray, "V 3"], Float[np.ndarray, "V 3"], float]:
    """(V, 3) a mixture as it is, (V, 3) as it lies on the surface, bent, and the strain, see `_System.strain`.

    Args:
        of: what known shapes span, at unit area of the new one.
        mesh: one of them, for its faces.
        on: a net on it.
        places: about where their vertices lie on the surface.
        onto: the surface.

    Reference:
        The energy is that of Sumner, Schmid and Pauly, "Embedded deformation for shape manipulation", ACM Transactions
        on Graphics 26 (2007), of edges that are as long and lie as in the mixture, not as in a fixed shape, with the
        weights of Geman and McClure, so that it prefers a few joints to a bend all over.
    """
    some = np.unique(np.linspace(0, len(places) - 1, min(POINTS, len(places))).astype(int))
    few = some[:: max(1, len(some) // 1000)]
    now, system = _begun(of, on, places), _System(of, on)
    three = np.tile(np.eye(3), (len(few), 1))
    for _ in range(FIRST):
        at = np.repeat(few, 3)
        now = system.step(now, at, three, places[at], np.full(len(at), 1 / len(few)), float(STIFFNESS[0]), ROUGH)
    marks = None if onto.normals is None else NORMALS * onto.normals
    tree = cKDTree(onto.points if marks is None else np.hstack([onto.points, marks]))
    back = np.unique(np.linspace(0, len(onto.points) - 1, min(BACK, len(onto.points))).astype(int))
    mass = of.mass[some] / of.mass[some].sum()
    for stiffness in STIFFNESS:
        points = system.lying(now)
        facing, at = normals(mesh, points), points[some]
        here = at if marks is None else np.hstack([at, NORMALS * facing[some]])
        there = onto.points[back] if marks is None else np.hstack([onto.points[back], marks[back]])
        found, ours = tree.query(here)[1], some[cKDTree(here).query(there)[1]]
        which, goals = np.concatenate([some, ours]), np.concatenate([onto.points[found], onto.points[back]])
        planes = facing[which] if onto.normals is None else onto.normals[np.concatenate([found, back])]
        off = ((goals - points[which]) * planes).sum(axis=1)
        shares = np.concatenate([mass, np.full(len(back), 1 / len(back))]) / 2 / (1 + (off / FAR) ** 2)
        now = system.step(now, which, planes, goals, shares, float(stiffness), SURE)
    return of.at(now.weights), system.lying(now), system.strain(now)


class _System:
    """The steps of Gauss and Newton's of mixture and bend together."""

    def __init__(self, of: Span, on: Net):
        self.of, self.on, self.count = of, on, len(on.knots)
        self.knot_modes = of.modes[:, on.knots]

    def lying(self, now: Bend) -> np.ndarray:
        """(V, 3) where the bent mixture lies."""
        points, on = self.of.at(now.weights), self.on
        off = points[:, None] - points[on.knots][on.followed]
        turned = np.einsum("vfx,vfxy->vfy", off, now.turns[on.followed]) + now.places[on.followed]
        return np.einsum("vf,vfx->vx", on.shares, turned)

    def strain(self, now: Bend) -> float:
        """How far edges of the net are from where the turns of their ends take them, over their lengths: root mean
        squares."""
        knots = self.of.at(now.weights)[self.on.knots]
        off, lengths = self._edges(now, knots)[2], np.linalg.norm(knots[self.on.j] - knots[self.on.i], axis=1)
        return float(np.sqrt((off**2).sum() / (lengths**2).sum()))

    def step(
        self, now: Bend, at: np.ndarray, planes: np.ndarray, goals: np.ndarray, shares: np.ndarray, stiffness: float,
        loose: float,
    ) -> Bend:  # fmt: skip
        """A step towards planes (s, 3) through goals (s, 3) of vertices (s,) that count by shares (s,).

        Args:
            loose: how much modes may vary for it, see `fit`.
        """
        points, on, r, n = self.of.at(now.weights), self.on, len(now.weights), self.count
        knots, follow = points[on.knots], on.shares[at]
        near = on.followed[at]
        turned = np.einsum("sfx,sfxy->sfy", points[at][:, None] - knots[near], now.turns[near])
        off = ((goals - np.einsum("sf,sfx->sx", follow, turned + now.places[near])) * planes).sum(axis=1)
        facing = follow[..., None] * np.einsum("sfxy,sy->sfx", now.turns[near], planes)
        along = np.einsum("rsx,sx->sr", self.of.modes[:, at], facing.sum(axis=1))
        along -= np.einsum("rsfx,sfx->sr", self.knot_modes[:, near], facing)
        cross = follow[..., None] * np.cross(turned, planes[:, None])
        moves = follow[..., None] * planes[:, None]
        columns = 3 * near[..., None] + np.arange(3)
        rows = np.broadcast_to(np.arange(len(at))[:, None, None], columns.shape)
        local = _sparse(rows, [columns, 3 * n + columns], [cross, moves], (len(at), 6 * n))
        edge_local, edge_along, edge_off = self._edges(now, knots)
        bends = 1 / (1 + (edge_off.reshape(-1, 3) ** 2).sum(axis=1) / JOINT**2)
        weight = np.repeat(stiffness / len(on.i) * bends, 3)
        prior = loose / self.of.deviations**2
        left, right = np.zeros((r + 6 * n,) * 2), np.zeros(r + 6 * n)
        for sparse, dense, wanted, w in ((local, along, off, shares), (edge_local, edge_along, edge_off, weight)):
            weighed = csr_array(sparse.multiply(w[:, None]))
            left[r:, r:] += (sparse.T @ weighed).toarray()
            left[r:, :r] += weighed.T @ dense
            left[:r, :r] += dense.T @ (w[:, None] * dense)
            right[r:] += weighed.T @ wanted
            right[:r] += dense.T @ (w * wanted)
        left[:r, r:] = left[r:, :r].T
        right[:r] -= prior * now.weights
        left[np.diag_indices(r)] += prior
        left[np.diag_indices_from(left)] += 1e-10 * np.trace(left) / len(left)
        step = cho_solve(cho_factor(left, check_finite=False), right, check_finite=False)
        turn = Rotation.from_rotvec(step[r : r + 3 * n].reshape(n, 3)).as_matrix().transpose(0, 2, 1)
        return replace(
            now,
            weights=now.weights + step[:r],
            turns=now.turns @ turn,
            places=now.places + step[r + 3 * n :].reshape(n, 3),
        )

    def _edges(self, now: Bend, knots: np.ndarray) -> tuple[csr_array, np.ndarray, np.ndarray]:
        """Rows of the edges of the net, three each: of turns and places, of modes, and what they are off."""
        on, n = self.on, self.count
        u = np.einsum("mx,mxy->my", knots[on.j] - knots[on.i], now.turns[on.i])
        off = now.places[on.j] - now.places[on.i] - u
        along = np.einsum("rmx,mxy->myr", self.knot_modes[:, on.j] - self.knot_modes[:, on.i], now.turns[on.i])
        m, zero = len(u), np.zeros(len(u))
        x, y, z = u.T
        skew = np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=1).reshape(m, 3, 3)  # row c: (θ × u)_c of θ
        rows = 3 * np.arange(m)[:, None] + np.arange(3)
        spread = np.broadcast_to(rows[..., None], (m, 3, 3))
        turns = np.broadcast_to(3 * on.i[:, None, None] + np.arange(3), (m, 3, 3))
        here, there = (3 * n + 3 * k[:, None] + np.arange(3) for k in (on.i, on.j))
        data = np.concatenate([skew.ravel(), np.ones(3 * m), -np.ones(3 * m)])
        where = np.concatenate([spread.ravel(), rows.ravel(), rows.ravel()])
        columns = np.concatenate([turns.ravel(), here.ravel(), there.ravel()])
        sparse = csr_array((data, (where, columns)), shape=(3 * m, 6 * n))
        return sparse, along.reshape(3 * m, -1), off.ravel()


def _begun(of: Span, on: Net, places: np.ndarray) -> Bend:
    """The mean, its knots turned and moved as what follows them is."""
    n, f = len(on.knots), on.followed.shape[1]
    weights = (of.mass[:, None] * on.shares).ravel()
    knot = on.followed.ravel()

    def sums(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), -1)
        found = [np.bincount(knot, weights * np.repeat(column, f), minlength=n) for column in flat.T]
        return np.stack(found, axis=1).reshape(n, *values.shape[1:])

    total = sums(np.ones(len(places)))[:, None]
    here, there = sums(of.mean) / total, sums(places) / total
    products = sums(of.mean[:, :, None] * places[:, None]) / total[..., None] - here[:, :, None] * there[:, None]
    turns = nearest_rotation(products)
    at = there + np.einsum("nx,nxy->ny", of.mean[on.knots] - here, turns)
    return Bend(np.zeros(len(of.deviations)), turns, at)


def _sparse(rows: np.ndarray, columns: list[np.ndarray], values: list[np.ndarray], shape: tuple[int, int]) -> csr_array:
    where = np.tile(rows.ravel(), len(columns))
    data, at = (np.concatenate([part.ravel() for part in parts]) for parts in (values, columns))
    return csr_array((data, (where, at)), shape=shape)
