"""A chain with masses on it and elements that give way."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, Chain, Placement, Vector


@dataclass(frozen=True)
class PointMass:
    """A mass [kg] at `com` (3,) [m] in the running frame at the chain's mark number `mark`."""

    mark: int
    mass: float
    com: Vector


class LocalMass(NamedTuple):
    """Sums of masses: mass (k,) [kg] and first moment (k, 3) [kg m] in the frame where they sit."""

    mass: Array
    moment: Array


@dataclass(frozen=True)
class Mechanism:
    """A chain under gravity.

    The chain's first mark is the robot's base, its last one the tool.

    Attributes:
        gravity: (3,) [m/s2] in the base frame.
        elastic: indices of the elements that give way, ascending; all are moving elements.
    """

    chain: Chain
    masses: tuple[PointMass, ...]
    gravity: Vector
    elastic: tuple[int, ...]

    @cached_property
    def elastic_index(self) -> NDArray[np.intp]:
        """The elastic elements, (elastic,)."""
        return np.array(self.elastic, dtype=int)

    @cached_property
    def elastic_rows(self) -> NDArray[np.intp]:
        """Rows of the elastic elements among the moving ones; they start the frames that follow."""
        return np.searchsorted(self.chain.moving_index, self.elastic_index)

    @cached_property
    def elastic_turns(self) -> NDArray[np.bool_]:
        """Which elastic elements rotate, (elastic,)."""
        return self.chain.rotates[self.elastic_index]

    @cached_property
    def below_diagonal(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Pairs of elastic elements, the second one before the first."""
        return np.tril_indices(len(self.elastic), -1)

    @cached_property
    def _frame_bodies(self) -> Array:
        """(frames, bodies) one where the body belongs to the frame."""
        return (np.arange(len(self.chain.moving) + 1)[:, None] == self.chain.body_frames).astype(float)

    @cached_property
    def _earlier_bodies(self) -> Array:
        """(bodies, bodies) one where the column's body precedes the row's in the same frame."""
        return np.tril(self._frame_bodies.T @ self._frame_bodies, -1)

    @cached_property
    def _mass_arrays(self) -> tuple[NDArray[np.intp], Array, Array]:
        marks = np.array([mass.mark for mass in self.masses], dtype=int)
        com = np.array([mass.com for mass in self.masses]).reshape(-1, 3, 1)
        return marks, np.array([mass.mass for mass in self.masses]), com

    def masses_in_frames(self, placement: Placement) -> LocalMass:
        """All masses of each frame."""
        return self._summed(self._frame_bodies, placement)

    def masses_before_bodies(self, placement: Placement) -> LocalMass:
        """The masses of each body's frame that sit before the body, and so do not move with it."""
        return self._summed(self._earlier_bodies, placement)

    def presses(self, body: int, wrench: bool) -> bool:
        """Whether motion of a body changes any load: it comes after the base and carries a mass, or the wrench."""
        carried = [self.chain.mark_bodies[mass.mark] for mass in self.masses]
        if wrench:
            carried.append(self.chain.mark_bodies[-1])
        return bool(self.chain.mark_bodies[0] < body <= max(carried, default=-1))

    def _summed(self, groups: Array, placement: Placement) -> LocalMass:
        marks, mass, com = self._mass_arrays
        at = (placement.mark_rotations[marks] @ com)[:, :, 0] + placement.mark_origins[marks]
        members = groups[:, self.chain.mark_bodies[marks]] * mass
        return LocalMass(members.sum(axis=1), members @ at)
