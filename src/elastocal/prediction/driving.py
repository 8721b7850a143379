"""Driving a robot: where a block of joint positions puts its target, and how the target follows each joint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, Placement, place
from elastocal.elasticity import at_deflections, settle
from elastocal.prediction.columns import fill_jacobian, target_position, target_rotation
from elastocal.robot import Assembly, JointMap, Robot, assemble, harmonics


class Driven(NamedTuple):
    """A block of poses.

    Attributes:
        position: (3, n) of the target in the instrument's frame [m].
        rotation: (3, 3, n) of the target into the instrument's frame.
        jacobian: (6, joints, n) displacement and rotation vector of the target per unit of each of the controller's
            joint positions; (0, joints, n) if not asked for.
    """

    position: Array
    rotation: Array
    jacobian: Array


@dataclass(frozen=True)
class Driver:
    """A robot put together, to be moved by its joints."""

    assembly: Assembly
    placement: Placement

    @classmethod
    def of(cls, robot: Robot, station: str | None = None, target: str | None = None, load: str | None = None) -> Driver:
        """The robot seen from a station (None: the base), with a target (None: the tool's origin) and a payload.

        Raises:
            KeyError: a name that the robot does not have.
        """
        assembly = assemble(robot, station, target, load)
        chain = assembly.mechanism.chain
        return cls(assembly, place(chain, chain.values))

    @cached_property
    def driven(self) -> NDArray[np.intp]:
        """Rows of the driven elements among the moving ones, in the order of the model's joints."""
        return np.array([row for row, drive in enumerate(self.assembly.drives) if drive.joint is not None], dtype=int)

    def at(self, q: Array, wrench: Array | None = None, sides: Array | None = None, derivatives: bool = True) -> Driven:
        """Drive to the controller's joint positions q (joints, n) under gravity and a wrench (6, n) on the tool.

        Args:
            q: joint positions [rad or m].
            wrench: force first, in the tool's frame [N, N m].
            sides: (elastic, n) loads that decide the sides of laws with a transition torque; NaN, or None: those of the
                undeflected configuration do.
            derivatives: whether to fill in the Jacobian. It includes what deflections and joint maps answer, with the
                sides as they are.

        Raises:
            EquilibriumError: a pose does not settle under its load.
        """
        assembly = self.assembly
        motion = assembly.motion(q)
        if assembly.springs:
            state = settle(assembly.mechanism, self.placement, assembly.springs, motion, wrench, sides)
        else:  # nothing to settle
            state = at_deflections(assembly.mechanism, self.placement, (), motion, np.zeros((0, q.shape[1])), wrench)
        jacobian = np.empty((6 if derivatives else 0, len(self.driven), q.shape[1]))
        if derivatives:
            fill_jacobian(state, assembly.mechanism.chain.moving_index[self.driven], [], True, jacobian)
            jacobian *= self._rates(q)
        if assembly.coupling is not None:
            jacobian = assembly.coupling.T @ jacobian
        return Driven(target_position(state), target_rotation(state), jacobian)

    def undeflected_loads(self, q: Array, wrench: Array | None = None) -> Array:
        """Loads [N m or N] of the elastic elements (elastic, n) as long as nothing gives way; they decide sides."""
        assembly, held = self.assembly, np.zeros((len(self.assembly.springs), q.shape[1]))
        motion = assembly.motion(q)
        state = at_deflections(assembly.mechanism, self.placement, assembly.springs, motion, held, wrench)
        return state.statics.loads

    def _rates(self, q: Array) -> Array:
        """How fast each driven element follows the model's joint, (model joints, n) or (model joints, 1)."""
        drives = [self.assembly.drives[row] for row in self.driven]
        signs = np.array([float(drive.sign) for drive in drives])[:, None]
        if all(drive.error is None for drive in drives):
            return signs
        model = self.assembly.model_positions(q)
        rates = np.repeat(signs, q.shape[1], axis=1)
        for rate, position, drive in zip(rates, model, drives, strict=True):
            if drive.error is not None:
                rate += map_slope(drive.error, position)
        return rates


def map_slope(error: JointMap, q: Array) -> Array:
    """Derivative (n,) of a joint map at joint positions q (n,) of the model."""
    orders = np.arange(1, len(error.sin) + 1)
    weights = np.stack([-orders * np.array(error.cos), orders * np.array(error.sin)], axis=1).ravel()
    return weights @ harmonics(q, len(orders))
