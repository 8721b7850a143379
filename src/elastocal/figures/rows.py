"""The rows of a calibration as figures need them: where the target was, the loads, and what is left, joint by joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification import AnyResult, Residuals, RowErrors
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Frame, Robot

MOST_ROWS = 20_000
"""Rows that figures are made of; more are thinned evenly first."""

LEAST_LEVER = 0.15
"""A row tells of a joint if the joint moves the target by this share or more of what it does at most."""


LEAST_OF_ALL = 0.01
"""A joint is told of if it moves the target by this share or more of what the most effective one does: the last joint
does not where the target is on its axis."""


@dataclass(frozen=True)
class Rows:
    """Rows of a calibration, thinned; base frame, SI.

    Attributes:
        total: how many there are in all.
        index: (n,) which of them these are.
        held_out: (n,) whether they were held out.
        left_out: (n,) whether they were left out of the fit as outliers.
        joints: (n, joints) positions of the model's joints [rad or m].
        position: (n, 3) measured position of the target [m].
        before: (n, 3) measured - predicted by the nominal robot [m]; of distances, along the line of sight.
        after: (n, 3) the same by the identified robot.
        loads: on each joint and each elastic element, of the undeflected configuration, (n,) [N m or N].
        motion: what is left, as a motion of one joint or element alone, (n,) [rad or m]; NaN where it hardly moves the
            target.
        weight: (n,) square of what a unit of this motion moves the target by.
    """

    total: int
    index: NDArray[np.intp]
    held_out: NDArray[np.bool_]
    left_out: NDArray[np.bool_]
    joints: Array
    position: Array
    before: Array
    after: Array
    loads: Mapping[str, Array]
    motion: Mapping[str, Array]
    weight: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.index)

    @property
    def measured(self) -> bool:
        """Whether positions or distances were measured at all."""
        return bool(np.isfinite(self.after).any())


def rows_of(result: AnyResult, most: int = MOST_ROWS) -> Rows:
    """The rows of a result, evenly thinned.

    Raises:
        EquilibriumError: a pose does not settle under its load.
        ValueError: the result was read without its rows.
    """
    errors = errors_of(result)
    n = len(errors.data)
    index = np.arange(n) if n <= most else np.linspace(0, n - 1, most).astype(int)
    data, robot = errors.data.take(index), result.robot
    predicted, columns, loads = _predicted(robot, data)
    rotation, origin = _bases(robot, data)
    direction = predicted / np.maximum(np.linalg.norm(predicted, axis=1, keepdims=True), 1e-12)
    before, after = (_vectors(found, index, direction) for found in (errors.nominal, errors.calibrated))
    along = _is_distance(errors.calibrated, index)
    motion, weight = _motions(columns, after, np.where(along[:, None], direction, np.nan))
    coupling = robot.coupling

    def in_base(vectors: Array) -> Array:
        return np.einsum("nij,ni->nj", rotation, vectors)

    left_out = np.isin(index, [o.index for o in result.outliers if o.rejected])
    joints = data.q if coupling is None else data.q @ np.array(coupling).T
    return Rows(
        total=n,
        index=index,
        held_out=errors.held_out[index],
        left_out=left_out,
        joints=joints,
        position=in_base(predicted + after - origin),
        before=in_base(before),
        after=in_base(after),
        loads=loads,
        motion=motion,
        weight=weight,
    )


def _motions(columns: Mapping[str, Array], left: Array, sight: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """What is left (n, 3) as a motion of each element alone, and the squares of what it moves the target by.

    Args:
        columns: what the target's position changes with the elements, (n, 3) each.
        left: (n, 3) residuals.
        sight: (n, 3) the line of sight of rows of which only what lies along it counts, NaN of others.
    """
    motion, weight, longest = {}, {}, {True: 0.0, False: 0.0}
    for element, column in columns.items():
        along = sight * (column * sight).sum(axis=1, keepdims=True)
        used = np.where(np.isfinite(sight), along, column)
        weight[element] = (used**2).sum(axis=1)
        longest[turns(element)] = max(longest[turns(element)], float(weight[element].max(initial=0.0)))
        motion[element] = (used * left).sum(axis=1)
    for element, square in weight.items():
        own, any_ = float(square.max(initial=0.0)), longest[turns(element)]
        tells = (square > LEAST_LEVER**2 * own) & (own > LEAST_OF_ALL**2 * any_)
        motion[element] = np.where(tells, motion[element] / np.where(tells, square, 1.0), np.nan)
    return motion, weight


def errors_of(result: AnyResult) -> RowErrors:
    """The residuals of a result's rows.

    Raises:
        ValueError: the result was read without its rows.
    """
    if result.errors is None:
        raise ValueError("the result has no rows: there is no residuals.csv in its folder")
    return result.errors


def driven_elements(robot: Robot) -> tuple[str, ...]:
    """The elements that joints drive, in their order."""
    return tuple(row.joint_element for row in robot.joints if row.joint_element)


def turns(element: str) -> bool:
    """Whether an element is a rotation."""
    return element.rpartition(".")[2] in ("alpha", "beta", "theta", "rx", "ry", "rz")


def _predicted(robot: Robot, data: Measurements) -> tuple[Array, dict[str, Array], dict[str, Array]]:
    """Positions (n, 3), what they change with each joint and elastic element (n, 3), and the loads on these (n,)."""
    elements = tuple(dict.fromkeys((*driven_elements(robot), *robot.elastic)))
    springs = {element: robot.elastic.get(element, Compliance.rigid("linear")) for element in elements}
    asked = replace(data, position=np.zeros((len(data), 3)), orientation=None, distance=None)
    model = Model(replace(robot, elastic=springs), elements, asked)
    here = np.zeros(len(elements))
    position, columns = np.empty((len(data), 3)), np.empty((len(data), 3, len(elements)))
    for part in model.parts(here):
        position[part.rows] = -part.residual.T
        columns[part.rows] = part.jacobian[:, :-1].transpose(2, 0, 1)
    loads = model.undeflected_loads(here)
    return position, {e: columns[:, :, i] for i, e in enumerate(elements)}, loads


def _vectors(found: Residuals, index: NDArray[np.intp], direction: Array) -> Array:
    """Residuals as vectors (n, 3) in the instrument's frame, those of distances along the line of sight."""
    vectors = np.full((len(index), 3), np.nan) if found.position is None else found.position[index]
    if found.distance is None:
        return vectors
    return np.where(np.isfinite(vectors), vectors, found.distance[index, None] * direction)


def _is_distance(found: Residuals, index: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(n,) whether a row has no position, but perhaps a distance."""
    if found.position is None:
        return np.ones(len(index), dtype=bool)
    return ~np.isfinite(found.position[index, 0])


def _bases(robot: Robot, data: Measurements) -> tuple[Array, Array]:
    """Of each row, the rotation (n, 3, 3) and origin (n, 3) of the base in the instrument's frame."""
    names: list[str | None] = [None] * len(data)
    if data.station is not None:
        names = [data.station.name(int(code)) for code in data.station.codes]
    frames: dict[str | None, Frame] = {None: robot.base}
    frames.update(robot.stations)
    used = sorted(set(names), key=str)
    code = np.array([used.index(name) for name in names], dtype=int)
    rotations = np.array([frames[name].rotation for name in used])
    origins = np.array([frames[name].translation for name in used])
    return rotations[code], origins[code]


@dataclass(frozen=True)
class Means:
    """Weighted means of rows in bins of a quantity.

    Attributes:
        at: (bins,) mean of the quantity.
        mean: (bins,) of the values, with its standard error `error`.
        share: of the values' variance, what the bins explain, from 0 to 1, less what they explain by chance.
        probability: of bins that explain as much by chance (F test).
    """

    at: Array
    mean: Array
    error: Array
    share: float
    probability: float


def binned(x: Array, values: Array, weight: Array, bins: int) -> Means:
    """Means of values (n,) in bins of like numbers of rows along x (n,); rows that are not finite do not count."""
    good = np.isfinite(x) & np.isfinite(values) & (weight > 0.0)
    order = np.flatnonzero(good)[np.argsort(x[good], kind="stable")]
    bins = max(1, min(bins, len(order) // 4))
    if not len(order):
        return Means(np.empty(0), np.empty(0), np.empty(0), 0.0, 1.0)
    x, values, weight = x[order], values[order], weight[order]
    starts = np.unique(np.linspace(0, len(order), bins + 1).astype(int)[:-1])
    number = np.searchsorted(starts, np.arange(len(order)), side="right") - 1
    total = np.add.reduceat(weight, starts)
    mean = np.add.reduceat(weight * values, starts) / total
    left = weight * (values - mean[number])
    sizes = np.diff(starts, append=len(order))
    error = np.sqrt(np.add.reduceat(left**2, starts) * sizes / np.maximum(sizes - 1, 1)) / total
    grand = weight @ values / weight.sum()
    within, whole = float(weight @ (values - mean[number]) ** 2), float(weight @ (values - grand) ** 2)
    return Means(np.add.reduceat(x, starts) / sizes, mean, error, *_explained(within, whole, len(order), len(starts)))


def _explained(within: float, whole: float, n: int, k: int) -> tuple[float, float]:
    """The share of n values' squares that k means explain beyond chance, and the probability that chance does."""
    from scipy.special import fdtrc  # imported late: it takes longer than a calibration

    if not (n > k > 1 and within > 0.0 and whole > within):
        return 0.0, 1.0
    share = 1.0 - within / (n - k) * (n - 1) / whole
    ratio = (whole - within) / (k - 1) / (within / (n - k))
    return float(np.clip(share, 0.0, 1.0)), float(fdtrc(k - 1, n - k, ratio))
