"""A robot that carries, row by row, the TCP and the payload that its targets ask for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.targets import Targets
from elastocal.elasticity import Law
from elastocal.errors import EquilibriumError
from elastocal.prediction.driving import Driven, Driver
from elastocal.robot import Frame, Robot

HERE = Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)


@dataclass(frozen=True)
class Machine:
    """Rows of one robot, seen in its base frame.

    Attributes:
        drivers: the robot put together for each TCP and payload that occurs.
        group: (n,) which of them a row has.
        wrench: (6, n) on the tool, or None.
        first: number of the first row among all, from 0, for messages.
    """

    drivers: tuple[Driver, ...]
    group: NDArray[np.intp]
    wrench: Array | None = None
    first: int = 0

    @classmethod
    def of(cls, robot: Robot, targets: Targets, first: int = 0) -> Machine:
        """The robot for some targets."""
        here, n = replace(robot, base=HERE), len(targets)
        target = np.full(n, -1) if targets.target is None else targets.target.codes.astype(int)
        load = np.full(n, -1) if targets.load is None else targets.load.codes.astype(int)
        pairs, group = np.unique(np.stack([target, load], axis=1), axis=0, return_inverse=True)
        drivers = [
            Driver.of(
                here,
                target=None if targets.target is None else targets.target.name(t),
                load=None if targets.load is None else targets.load.name(k),
            )
            for t, k in pairs.tolist()
        ]
        return cls(tuple(drivers), group.ravel(), None if targets.wrench is None else targets.wrench.T.copy(), first)

    @cached_property
    def stepping(self) -> tuple[int, ...]:
        """Numbers of the elastic elements whose law jumps at its transition torque."""
        springs = [spring for driver in self.drivers[:1] for spring in driver.assembly.springs]
        return tuple(
            i
            for i, spring in enumerate(springs)
            if isinstance(spring.law, Law) and spring.law.transition and spring.law.transition_slopes is None
        )

    def springs(self) -> tuple[str, ...]:
        """Names of the elastic elements."""
        mechanism = self.drivers[0].assembly.mechanism
        return tuple(mechanism.chain.elements[i].name for i in mechanism.elastic)

    def at(self, q: Array, rows: NDArray[np.intp], sides: Array | None = None, derivatives: bool = True) -> Driven:
        """Drive rows (k,), which may repeat, to joint positions q (joints, k); loads `sides` (elastic, k) as there.

        Raises:
            EquilibriumError: a row does not settle under its load; names it.
        """
        if len(self.drivers) == 1:
            return self._driven(0, q, rows, sides, derivatives)
        k = len(rows)
        out = Driven(np.empty((3, k)), np.empty((3, 3, k)), np.empty((6 if derivatives else 0, len(q), k)))
        for number in np.unique(self.group[rows]).tolist():
            of = np.flatnonzero(self.group[rows] == number)
            part = self._driven(number, q[:, of], rows[of], None if sides is None else sides[:, of], derivatives)
            for whole, some in zip(out, part, strict=True):
                whole[..., of] = some
        return out

    def _driven(self, number: int, q: Array, rows: NDArray[np.intp], sides: Array | None, derivatives: bool) -> Driven:
        wrench = None if self.wrench is None else self.wrench[:, rows]
        try:
            return self.drivers[number].at(q, wrench, sides, derivatives)
        except EquilibriumError as error:
            row = int(rows[error.pose])
            raise EquilibriumError(error.element, row, f"target {self.first + row + 1}") from None

    def undeflected_loads(self, q: Array, rows: NDArray[np.intp]) -> Array:
        """Loads that decide sides, (elastic, k), of rows (k,) at joint positions q (joints, k)."""
        loads = np.empty((len(self.springs()), len(rows)))
        for number in np.unique(self.group[rows]).tolist():
            of = np.flatnonzero(self.group[rows] == number)
            wrench = None if self.wrench is None else self.wrench[:, rows[of]]
            loads[:, of] = self.drivers[number].undeflected_loads(q[:, of], wrench)
        return loads


def rigid(robot: Robot) -> Robot:
    """The robot as a controller knows it: without compliance, joint maps and masses."""
    return replace(
        robot,
        elastic={},
        transmission={},
        rows=tuple(replace(row, mass=0.0) for row in robot.rows),
        tool_load=replace(robot.tool_load, mass=0.0),
        loads={name: replace(load, mass=0.0) for name, load in robot.loads.items()},
    )


def joint_limits(robot: Robot) -> tuple[Array, Array]:
    """Lowest and highest joint positions of the controller (joints,); infinite where there are none.

    Of a robot whose coupling has other numbers of joints on its two sides none are known.
    """
    if robot.positions != len(robot.joints):
        return np.full(robot.positions, -np.inf), np.full(robot.positions, np.inf)
    limits = [row.limits or (-np.inf, np.inf) for row in robot.joints]
    low, high = np.array(limits, dtype=float).T
    return low, high


def slides(robot: Robot) -> NDArray[np.bool_]:
    """Which of the controller's joint positions are lengths, (joints,)."""
    found = [row.joint == "prismatic" for row in robot.joints][: robot.positions]
    return np.array(found + [False] * (robot.positions - len(found)))
