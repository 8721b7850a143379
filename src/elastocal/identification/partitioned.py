"""A robot that predicts partitions: its normal equations are the sums of those of all parts, in their order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.sums import Sums, Variances, added, normal_sums
from elastocal.identification.threads import one_thread
from elastocal.measurements import KINDS, Measurements
from elastocal.parallel import in_order
from elastocal.partitions import Part, Partitions
from elastocal.prediction import Model
from elastocal.robot import Robot

Result = TypeVar("Result")


@dataclass(frozen=True)
class Marks:
    """What was settled of a part's rows before all rows are fitted, a bit for each row.

    Attributes:
        good: which rows are fitted; None: all.
        high: by element with a step, which rows lie above its transition torque.
    """

    good: bytes | None = None
    high: Mapping[str, bytes] = field(default_factory=dict)

    def weights(self, rows: int) -> Array | None:
        """(rows,) how much each counts; None: all one."""
        return None if self.good is None else unpacked(self.good, rows).astype(float)

    def sides(self, rows: int) -> dict[str, Array]:
        """By element, loads (rows,) that decide the sides of its law as they are marked."""
        return {element: np.where(unpacked(bits, rows), np.inf, 0.0) for element, bits in self.high.items()}


class Marked(NamedTuple):
    """A part with what was settled of it."""

    part: Part
    marks: Marks


@dataclass(frozen=True)
class Partitioned:
    """A robot that predicts partitions, as a function of displacements of named parameters; see `Model`.

    Attributes:
        robot: where all displacements are zero.
        names: the parameters that are displaced.
        data: what is predicted.
        marks: of each part.
        executor: where parts are worked through; None: here, one after the other. The result is the same.
    """

    robot: Robot
    names: tuple[str, ...]
    data: Partitions
    marks: tuple[Marks, ...]
    executor: Executor | None = field(default=None, compare=False, repr=False)

    @property
    def fitted(self) -> int:
        """How many rows are fitted."""
        rows = zip(self.data.parts, self.marks, strict=True)
        return sum(p.rows if m.good is None else int(unpacked(m.good, p.rows).sum()) for p, m in rows)

    def displaced(self, displacements: Array) -> Robot:
        """The robot at displacements (parameters,)."""
        return self.robot.displaced(dict(zip(self.names, displacements.tolist(), strict=True)))

    def normal_sums(self, displacements: Array, variances: Variances, held: bool = False) -> Sums:
        """Sum over all parts; see `sums.normal_sums`."""
        several = self.data.several_stations
        sum_of = partial(_sums_of, self.robot, self.names, several, displacements, variances, held)
        return added(self.each(sum_of))

    def each(self, function: Callable[[Marked], Result]) -> Iterator[Result]:
        """A function of each part, in their order."""
        return over_parts(function, self.data, self.marks, self.executor)


def over_parts(
    function: Callable[[Marked], Result], data: Partitions, marks: Sequence[Marks], executor: Executor | None
) -> Iterator[Result]:
    """A function of each part with its marks, in their order."""
    return in_order(function, list(map(Marked, data.parts, marks)), executor, chunk=1)


@one_thread
def _sums_of(
    robot: Robot,
    names: tuple[str, ...],
    several: bool,
    displacements: Array,
    variances: Variances,
    held: bool,
    marked: Marked,
) -> Sums:
    data, rows = marked.part.read(), marked.part.rows
    model = Model(robot, names, data, marked.marks.sides(rows), marked.marks.weights(rows))
    channel = channels_of(data, several)
    own = {kind: variances.get(name, variances.get(kind, 0.0)) for kind, name in channel.items()}
    found = normal_sums(model, displacements, {**variances, **own}, held)
    return {channel.get(name, name): sums for name, sums in found.items()}


def channels_of(data: Measurements, several: bool) -> dict[str, str]:
    """Of a part that is from one station, where all data are from several: the channel that each kind belongs to."""
    stations = {found.station for found in data.combinations}
    if not several or len(stations) > 1:
        return {}
    station = stations.pop() or "base"
    return {kind: f"{kind} {station}" for kind in KINDS}


def packed(rows: NDArray[np.bool_]) -> bytes:
    """A bit for each row."""
    return np.packbits(rows).tobytes()


def unpacked(bits: bytes, rows: int) -> NDArray[np.bool_]:
    """The rows (rows,) that bits stand for."""
    return np.unpackbits(np.frombuffer(bits, dtype=np.uint8), count=rows).astype(bool)
