"""Faults of a data set as a whole, each with the data as they were meant: swapped axes, units, joint order, names.

A fault of the rows of one file is a fault of these rows only, where there are several files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Robot

AXES = "xyz"

MOST_FILES = 20
"""Of more files than these only all together are looked at."""


@dataclass(frozen=True)
class Fault:
    """Something that may be wrong with some rows.

    Attributes:
        file: that these rows are; "" if all are.
        found: what is wrong, a sentence's middle: "axes x and y are swapped".
        remedy: what to do.
        robot, data: as they were meant.
        freedom: how many times nearer the data it is by itself, since it leaves more to be fitted.
    """

    file: str
    found: str
    remedy: str
    robot: Robot
    data: Measurements
    freedom: float = 1.0


def faults(robot: Robot, data: Measurements) -> Iterator[Fault]:
    """Every fault that could be told from these data, likely ones first.

    Args:
        robot: nominal, its open frames open.
        data: as they were read.
    """
    for file, rows in _parts(data):
        for found, remedy, changed in _changes(robot, data, rows):
            yield Fault(file, found, remedy, robot, replace(data, **changed))
    for prefix in _frames(data):
        frame = robot.frames[prefix]
        if frame.known:
            opened = robot.with_frames({prefix: replace(frame, known=False)})
            found = f"{prefix} is not where the robot file has it"
            yield Fault("", found, f"leave out known = true in its table [{prefix}]", opened, data, freedom=4.0)


_Change = tuple[str, str, dict[str, Any]]


def _parts(data: Measurements) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """All rows, and those of each file where there are several."""
    yield "", np.ones(len(data), dtype=bool)
    if data.source is not None and 1 < len(data.source.names) <= MOST_FILES:
        for code, name in enumerate(data.source.names):
            yield name, data.source.codes == code


def _changes(robot: Robot, data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    yield from _axes(robot, data, rows)
    yield from _units(robot, data, rows)
    yield from _joints(robot, data, rows)
    yield from _names(robot, data, rows)
    yield from _order(data, rows)


def _where(rows: NDArray[np.bool_], changed: Array, values: Array) -> Array:
    """Changed values in the rows that are meant."""
    return np.where(rows.reshape(-1, *(1,) * (values.ndim - 1)), changed, values)


def _axes(robot: Robot, data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    """Axes swapped or counted the other way; of what an unknown base makes good, only one mirror image is left."""
    if data.position is None:
        return
    tied = data.orientation is not None or not rows.all() or any(robot.frames[p].known for p in _stations(data))
    if not tied:
        mirrored = data.position * [1.0, 1.0, -1.0]
        found = (
            "the points are mirrored (left-handed): two of the axes x, y, z are swapped, or one counts the other way"
        )
        yield found, "swap two of the columns x, y, z, or change the sign of one", {"position": mirrored}
        return
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            if order == (0, 1, 2) and min(signs) > 0.0:
                continue
            told = ", ".join(f"{'-' if s < 0 else ''}{AXES[i]}" for i, s in zip(order, signs, strict=True))
            meant = _where(rows, data.position[:, order] * signs, data.position)
            yield _axes_found(order, signs), f"give {told} as x, y, z", {"position": meant}


def _axes_found(order: tuple[int, ...], signs: tuple[float, ...]) -> str:
    moved = [AXES[i] for i in range(3) if order[i] != i]
    turned = [AXES[i] for i, sign in zip(order, signs, strict=True) if sign < 0.0]
    told = []
    if len(moved) == 2:
        told.append(f"the axes {' and '.join(moved)} are swapped")
    elif moved:
        told.append("the axes x, y, z are permuted")
    if turned:
        told.append(f"{' and '.join(turned)} {'is' if len(turned) == 1 else 'are'} counted the other way")
    handed = np.linalg.det(np.eye(3)[list(order)] * signs) < 0.0
    return ", ".join(told) + (" (a left-handed, mirrored set of points)" if handed else "")


def _units(robot: Robot, data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    """Lengths and angles in other units than they were read in."""
    lengths = {kind: getattr(data, kind) for kind in ("position", "distance") if getattr(data, kind) is not None}
    for scale, (size, read, meant) in LENGTH_SLIPS.items():
        if lengths:
            changed = {kind: _where(rows, values * scale, values) for kind, values in lengths.items()}
            named = " and ".join(f"{kind}s" for kind in lengths)
            yield (
                f"the {named} are {size}: {meant} read as {read}",
                f"write the unit, as {'x' if 'position' in lengths else 'distance'} [{meant}]",
                changed,
            )
    turns = np.array([row.joint == "revolute" for row in robot.joints])
    if robot.coupling is not None and len(turns) != data.q.shape[1]:
        turns = np.ones(data.q.shape[1], dtype=bool)
    for scale, size, read, meant in ((np.pi / 180.0, "large", "rad", "deg"), (180.0 / np.pi, "small", "deg", "rad")):
        if turns.any():
            q = _where(rows, np.where(turns, data.q * scale, data.q), data.q)
            found = f"the joint angles are 57.3 times too {size}: {meant} read as {read}"
            yield found, f"write the unit, as q1 [{meant}]", {"q": q}


LENGTH_SLIPS = {
    1e-3: ("1000 times too large", "m", "mm"),
    1e3: ("1000 times too small", "mm", "m"),
    25.4e-3: ("39.4 times too large", "m", "in"),
    25.4: ("25.4 times too small", "mm", "in"),
    1.0 / 25.4: ("25.4 times too large", "in", "mm"),
    10.0: ("10 times too small", "mm", "cm"),
    0.1: ("10 times too large", "cm", "mm"),
}
"""By what lengths must be multiplied: how they look, what they were read as, what they are."""


def _joints(robot: Robot, data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    """Joint columns shifted, swapped, or counted the other way."""
    count = data.q.shape[1]
    names = [f"q{i + 1}" for i in range(count)]

    def ordered(order: Iterable[int]) -> dict[str, Any]:
        return {"q": _where(rows, data.q[:, list(order)], data.q)}

    for shift in (1, -1) if count > 2 else ():
        order = np.roll(np.arange(count), shift).tolist()
        listed = ", ".join(names[i] for i in order)
        yield "the joint columns are shifted by one", f"give {listed} as {', '.join(names)}", ordered(order)
    if count > 3:
        yield "the joints are in reverse order", "give the last one first", ordered(range(count)[::-1])
    for i, j in combinations(range(count), 2):
        order = list(range(count))
        order[i], order[j] = j, i
        yield f"the joints {names[i]} and {names[j]} are swapped", "swap these columns", ordered(order)
    for i in range(count):
        signs = np.where(np.arange(count) == i, -1.0, 1.0)
        remedy = f"change the sign of the column, or of the joint in {robot.name}'s file (sign = -1)"
        yield f"{names[i]} is counted the other way", remedy, {"q": _where(rows, data.q * signs, data.q)}


def _names(robot: Robot, data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    """Targets and stations that bear another one's name."""
    for kind, frames in (("target", robot.targets), ("station", robot.stations)):
        labels: Labels | None = getattr(data, kind)
        if labels is None:
            continue
        labels = Labels((*labels.names, *(name for name in frames if name not in labels.names)), labels.codes)
        used = [int(code) for code in np.unique(labels.codes[rows]) if code >= 0]
        for a, b in permutations(range(len(labels.names)), 2):
            first, second = labels.names[a], labels.names[b]
            if a not in used or not (frames[first].known or frames[second].known):
                continue
            renamed = np.where(rows & (labels.codes == a), b, labels.codes).astype(np.int32)
            found = f"what bears the name of {kind} {first!r} is {second!r}"
            yield found, f"correct the column {kind!r}", {kind: replace(labels, codes=renamed)}
            if b in used and first < second:
                both = np.where(rows & (labels.codes == b), a, renamed).astype(np.int32)
                found = f"the names of the {kind}s {first!r} and {second!r} are exchanged"
                yield found, f"correct the column {kind!r}", {kind: replace(labels, codes=both)}


def _order(data: Measurements, rows: NDArray[np.bool_]) -> Iterator[_Change]:
    """Readings that stand one row too low or too high."""
    mine = np.flatnonzero(rows)
    for shift, where in ((1, "below"), (-1, "above")):
        q = data.q.copy()
        q[mine] = data.q[np.roll(mine, -shift)]
        found = f"each reading stands one row {where} its joint positions"
        yield found, "move the columns of the joints against the others by one row", {"q": q}


def _stations(data: Measurements) -> set[str]:
    return {"base" if found.station is None else f"station.{found.station}" for found in data.combinations}


def _frames(data: Measurements) -> list[str]:
    """Prefixes of the frames that the data involve."""
    targets = {"tool", *(f"target.{found.target}" for found in data.combinations if found.target is not None)}
    return sorted(_stations(data) | targets)
