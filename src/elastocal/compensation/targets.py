"""What is to be reached: targets as they are given, and as goals in the base frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Frame, Robot


@dataclass(frozen=True)
class Targets:
    """Where the TCP is to go, one target a row; SI units.

    Attributes:
        position: (n, 3) of the TCP [m]; None: where the nominal robot is at `q`.
        orientation: (n, 3, 3) rotations of the TCP; None, or NaN in a row: any will do.
        q: (n, joints) the joint positions of a nominal program [rad or m]; beside positions, where the search starts.
        target: the robot's target that is the TCP; none: the tool's origin.
        load: payload in the robot.
        wrench: (n, 6) external wrench on the tool, force first, in the tool's frame [N, N m].
    """

    position: Array | None = None
    orientation: Array | None = None
    q: Array | None = None
    target: Labels | None = None
    load: Labels | None = None
    wrench: Array | None = None

    def __len__(self) -> int:
        given = self.q if self.position is None else self.position
        return 0 if given is None else len(given)

    def take(self, rows: slice | NDArray[np.intp]) -> Targets:
        """The targets of some rows."""
        chosen: dict[str, Any] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                chosen[field.name] = (
                    Labels(value.names, value.codes[rows]) if isinstance(value, Labels) else value[rows]
                )
        return Targets(**chosen)

    @classmethod
    def of(cls, given: Targets | Measurements | tuple[Array, Array] | Array) -> Targets:
        """Targets from themselves, from positions, from positions and rotations, or from what was measured."""
        if isinstance(given, Targets):
            return given
        if isinstance(given, Measurements):
            return cls(given.position, given.orientation, given.q, given.target, given.load, given.wrench)
        if isinstance(given, tuple):
            position, orientation = given
            return cls(np.asarray(position, dtype=float), np.asarray(orientation, dtype=float))
        return cls(np.atleast_2d(np.asarray(given, dtype=float)))


@dataclass(frozen=True)
class Goals:
    """Targets in the base frame, poses last.

    Attributes:
        position: (3, n) [m].
        rotation: (3, 3, n); the identity where it does not matter.
        oriented: (n,) whether the orientation matters.
        strict: (n,) whether a target whose orientation is not reached is not reached.
    """

    position: Array
    rotation: Array
    oriented: NDArray[np.bool_]
    strict: NDArray[np.bool_]

    def take(self, rows: NDArray[np.intp] | slice) -> Goals:
        """The goals of some rows."""
        return Goals(self.position[:, rows], self.rotation[:, :, rows], self.oriented[rows], self.strict[rows])


def goals_of(targets: Targets, frame: Frame | None) -> Goals:
    """Targets that are given as positions, in the base frame.

    Args:
        targets: with positions.
        frame: instrument_T_base if they are in the instrument's frame.
    """
    position = np.asarray(targets.position)
    n = len(position)
    oriented = np.zeros(n, dtype=bool)
    rotation = np.broadcast_to(np.eye(3), (n, 3, 3))
    if targets.orientation is not None:
        oriented = np.asarray(np.isfinite(targets.orientation).all(axis=(1, 2)))
        rotation = np.where(oriented[:, None, None], targets.orientation, rotation)
    if frame is not None:
        position = (position - frame.translation) @ frame.rotation
        rotation = np.where(oriented[:, None, None], frame.rotation.T @ rotation, rotation)
    return Goals(position.T.copy(), np.moveaxis(rotation, 0, -1).copy(), oriented, oriented)


def require_targets(targets: Targets, robot: Robot, nominal: Robot | None) -> None:
    """Check that targets are whole and that the robots have what they name.

    Raises:
        InputError: with every fault.
    """
    faults = list(_faults(targets, robot, nominal))
    if faults:
        raise InputError(*faults)


def _faults(targets: Targets, robot: Robot, nominal: Robot | None) -> Iterator[str]:
    if nominal is not None and nominal.positions != robot.positions:
        yield f"expected a nominal robot with {robot.positions} joints as {robot.name}, found {nominal.positions}"
    if targets.position is None and targets.q is None:
        yield "expected targets with positions, or joint positions of the nominal robot, found neither"
        return
    if targets.position is None and nominal is None:
        yield NO_NOMINAL
    n = len(targets)
    shapes = {"position": (n, 3), "orientation": (n, 3, 3), "q": (n, robot.positions), "wrench": (n, 6)}
    for name, shape in shapes.items():
        value = getattr(targets, name)
        if value is not None and value.shape != shape:
            yield f"{name}: expected an array {shape}, found {value.shape}"
        elif value is not None and name != "orientation" and not np.isfinite(value).all():
            row = int(np.flatnonzero(~np.isfinite(value).all(axis=1))[0])
            yield f"{name}: expected numbers, found {value[row]} in row {row + 1}"
    for kind, labels, valid in (("target", targets.target, robot.targets), ("load", targets.load, robot.loads)):
        used = [] if labels is None else [labels.names[code] for code in np.unique(labels.codes[labels.codes >= 0])]
        yield from (f"{robot.name} has {unknown_name(kind, name, valid)}" for name in used if name not in valid)


NO_NOMINAL = "q1 … qn alone are where the nominal robot would be, which is not known: give it (--nominal ROBOT)"
