"""Landmarks on the shapes of a folder: placed at vertices when asked for, and judged against the surfaces.

A landmark without a place is left out. A set that fits its surface far better with its axes turned, or in another unit,
is refused; the landmark farthest from the surface is named where it is out of line with the rest.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import index
from pathlib import Path

import numpy as np

from lssd_learn.collections.reading.landmark_table import Landmark, LandmarkTable
from lssd_learn.collections.reading.shape import ReadShape
from lssd_learn.collections.reading.spaces import in_space_of
from lssd_learn.collections.reading.surface import FRAMES, Surface, better_frame
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError

# A landmark is out of line if it is farther from the surface than NEAR of the shape's size and LINE times the median.
NEAR, LINE = 0.01, 10.0
# Of landmarks that say both, the vertex is expected within so much of the shape's size of the point.
SAME_PLACE = 0.05


@dataclass(frozen=True, eq=False)
class Placed:
    """The landmarks of one shape.

    Attributes:
        vertices: name → vertex of the cleaned shape.
        missing: names of those that have no place.
        distances: name → distance of its point from the surface, in parts of the shape's size.
        points: name → (3,) its point from the middle of the shape's box, in parts of its size.
        places: name → (3,) where it lies, in the coordinates of the file of the shape, on the surface or off it.
        space: "LPS" or "RAS", the coordinate system of these, if it is known; "".
    """

    vertices: dict[str, int] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    distances: dict[str, float] = field(default_factory=dict)
    points: dict[str, np.ndarray] = field(default_factory=dict)
    places: dict[str, np.ndarray] = field(default_factory=dict)
    space: str = ""


@dataclass(frozen=True, eq=False)
class Landmarks(Sequence):
    """Landmarks of each shape, placed when asked for: only then is the shape read.

    Args:
        path: of the table, or the files as a pattern, for messages.
        table: what it says.
        names: of the shapes.
        read: gives shape i.
        told: takes warnings.
    """

    path: Path
    table: LandmarkTable
    names: Sequence[str]
    read: Callable[[int], ReadShape]
    told: Told
    _placed: dict[int, Placed] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, i: int) -> dict[str, int]:
        return dict(self.place(range(len(self))[index(i)]).vertices)

    def place(self, i: int) -> Placed:
        """Landmarks of shape i.

        Raises:
            InputError: a vertex that is not there or was dropped, points of another frame, unit or shape.
        """
        if i not in self._placed:
            rows, missing = self.table.rows[i], self.table.missing[i]
            self._placed[i] = self._place(i, rows, list(missing)) if rows else Placed(missing=list(missing))
        return self._placed[i]

    @property
    def space(self) -> str:
        """The coordinate system of all landmarks; "" if it is not one, or not known."""
        spaces = {self.place(i).space for i, rows in enumerate(self.table.rows) if rows and self.table.space(i)}
        return spaces.pop() if len(spaces) == 1 else ""

    def check(self) -> None:
        """Compare the landmarks of all shapes, each placed, and say what is out of line."""
        all_placed = [self.place(i) for i in range(len(self))]
        missing = [f"{name} {' '.join(p.missing)}" for name, p in zip(self.names, all_placed, strict=True) if p.missing]
        if missing:
            more = f" and {len(missing) - 5:,} shapes more" if len(missing) > 5 else ""
            self.told.say(f"{self.path.name}: landmarks that are missing: {', '.join(missing[:5])}{more}")
        distances = [d for placed in all_placed for d in placed.distances.values()]
        typical = float(np.median(distances)) if distances else 0.0
        for name, placed in zip(self.names, all_placed, strict=True):
            if not placed.distances:
                continue
            mark, largest = max(placed.distances.items(), key=lambda item: item[1])
            if largest > max(NEAR, LINE * typical):
                self.told.warn(
                    f"{self.path.name}: landmark {mark!r} of {name} is off the surface by {100 * largest:.2g} % of the "
                    f"shape's size, the farthest of the shape; half of all landmarks are within {100 * typical:.2g} %"
                )
        self._compare_frames(all_placed)

    def _compare_frames(self, all_placed: Sequence[Placed]) -> None:
        """Say where the landmarks of a shape lie as those of the others do with their axes turned."""
        sums, counts = defaultdict(lambda: np.zeros(3)), defaultdict(int)
        for placed in all_placed:
            for mark, point in placed.points.items():
                sums[mark] += point
                counts[mark] += 1
        for name, placed in zip(self.names, all_placed, strict=True):
            common = [mark for mark in placed.points if counts[mark] > 2]
            if len(common) < 4:
                continue
            own = np.array([placed.points[mark] for mark in common])
            others = np.array([(sums[mark] - placed.points[mark]) / (counts[mark] - 1) for mark in common])
            misfit = np.linalg.norm(own - others)
            turned = [frame for frame in FRAMES if frame.is_turn]
            misfits = [np.linalg.norm(own @ frame.matrix - others) for frame in turned]
            best = int(np.argmin(misfits))
            if misfits[best] < misfit / 4 and misfit > 0.5 * np.linalg.norm(others - others.mean(axis=0)):
                self.told.warn(
                    f"{self.path.name}: the landmarks of {name} lie as those of the other shapes do with "
                    f"{turned[best].name}: mirrored or turned, if the shape itself is not"
                )

    def _place(self, i: int, rows: Sequence[Landmark], missing: list[str]) -> Placed:
        read = self.read(i)
        surface = Surface(read.original)
        rows, space = in_space_of(rows, self.table.space(i), read, surface, self.path.name, self.told)
        by_point = [landmark for landmark in rows if landmark.vertex is None]
        distances: dict[str, float] = {}
        if by_point:
            by_point, distances = self._with_point(by_point, surface, read, missing)
        self._check_pairs(
            [landmark for landmark in rows if None not in (landmark.vertex, landmark.point)], read, surface
        )
        vertices: dict[str, int] = {}
        places: dict[str, np.ndarray] = {}
        for landmark in rows:
            if landmark.name in missing:
                continue
            vertex = landmark.vertex
            if vertex is None:
                vertex = int(np.argmin(((read.original.points - landmark.point) ** 2).sum(1)))
            new = self._new_vertex(landmark, vertex, read, surface)
            if new is None:
                missing.append(landmark.name)
                continue
            vertices[landmark.name] = new
            places[landmark.name] = np.array(read.original.points[vertex] if landmark.point is None else landmark.point)
        by_vertex = defaultdict(list)
        for name, vertex in vertices.items():
            by_vertex[vertex].append(name)
        shared = [" and ".join(names) for names in by_vertex.values() if len(names) > 1]
        if shared:
            self.told.warn(f"{self.names[i]}: landmarks at one vertex: {', '.join(shared)}")
        middle = (surface.low + surface.high) / 2
        points = {landmark.name: (np.array(landmark.point) - middle) / surface.size for landmark in by_point}
        return Placed(vertices, missing, distances, points, places, space)

    def _with_point(
        self, landmarks: list[Landmark], surface: Surface, read: ReadShape, missing: list[str]
    ) -> tuple[list[Landmark], dict[str, float]]:
        """Those that are not codes for missing ones, with their distances; `missing` takes the names of the others."""
        points = np.array([landmark.point for landmark in landmarks])
        distances = surface.distances(points)
        sure = np.array([not landmark.doubtful for landmark in landmarks])
        line = max(NEAR * surface.size, LINE * float(np.median(distances[sure])) if sure.any() else 0.0)
        here = sure | (distances <= line)
        if not here.all():
            coded = [landmark for landmark, kept in zip(landmarks, here, strict=True) if not kept]
            missing.extend(landmark.name for landmark in coded)
            self.told.warn(
                f"{coded[0].where}: landmark {coded[0].name!r} at {' '.join(f'{x:g}' for x in coded[0].point or ())}, "
                "far from the surface, is taken as missing"
            )
            landmarks = [landmark for landmark, kept in zip(landmarks, here, strict=True) if kept]
            points, distances = points[here], distances[here]
        if not landmarks:
            return [], {}
        own = float(np.sqrt(np.square(distances).mean()))
        better = better_frame(surface, points, own)
        if better is not None:
            frame, misfit = better
            raise InputError(
                f"{self.path}: expected landmarks on {read.name}: they are off its surface by {own:.2g}, and by "
                f"{misfit:.2g} with {frame.name}; correct the table or the shape"
            )
        for landmark, point in zip(landmarks, points, strict=True):
            away = np.maximum(0, np.maximum(surface.low - point, point - surface.high)).max()
            if away > surface.size:
                raise InputError(
                    f"{landmark.where}: expected landmark {landmark.name!r} near {read.name}, which is "
                    f"{surface.size:.3g} across; it is {away:.3g} away from it"
                )
        names = [landmark.name for landmark in landmarks]
        return landmarks, dict(zip(names, (distances / surface.size).tolist(), strict=True))

    def _check_pairs(self, landmarks: Sequence[Landmark], read: ReadShape, surface: Surface) -> None:
        """Where both vertex and point are given: whether they are the same place, or would be counted from 1."""
        n = len(read.original.points)
        landmarks = [landmark for landmark in landmarks if landmark.vertex is not None and landmark.vertex <= n]
        if not landmarks:
            return
        vertices, points = np.array([lm.vertex for lm in landmarks]), np.array([lm.point for lm in landmarks])
        here = np.linalg.norm(read.original.points[np.minimum(vertices, n - 1)] - points, axis=1)
        before = np.linalg.norm(read.original.points[np.maximum(vertices - 1, 0)] - points, axis=1)
        far = SAME_PLACE * surface.size
        if len(landmarks) > 2 and np.median(here) > 2 * np.median(before) and np.median(before) < far:
            raise InputError(
                f"{landmarks[0].where}: expected vertices counted from 0: the points x, y, z of {read.name} lie at "
                f"the vertices counted from 1"
            )
        if here.max() > far:
            worst = landmarks[int(np.argmax(here))]
            self.told.warn(
                f"{worst.where}: vertex {worst.vertex} of {read.name} is {here.max():.3g} away from the point that the "
                f"table gives for landmark {worst.name!r}; the vertex is used"
            )

    def _new_vertex(self, landmark: Landmark, vertex: int, read: ReadShape, surface: Surface) -> int | None:
        """The vertex of the cleaned shape; of a shape with a mask the nearest that is left, None if none is near."""
        n = len(read.new_index)
        if vertex >= n:
            from_one = " (is it counted from 1?)" if vertex == n else ""
            raise InputError(
                f"{landmark.where}: expected a vertex of {read.name}, 0 to {n - 1}, got {vertex}{from_one}"
            )
        new = int(read.new_index[vertex])
        if new < 0 and read.masked:
            away = np.linalg.norm(read.shape.points - read.original.points[vertex], axis=1)
            near = bool(away.min() <= SAME_PLACE * surface.size)
            said = (
                f"{landmark.where}: landmark {landmark.name!r} of {read.name} is where the mask took the surface, "
                f"{100 * away.min() / surface.size:.2g} % of the shape's size from what is left"
            )
            if near:
                self.told.say(f"{said}; it is taken to the nearest vertex")
            else:
                self.told.warn(f"{said}, and is taken as missing")
            return int(away.argmin()) if near else None
        if new < 0:
            raise InputError(
                f"{landmark.where}: expected a vertex of the largest component of {read.name}, "
                f"landmark {landmark.name!r} is at vertex {vertex} of another piece, which is dropped"
            )
        return new
