"""Equilibrium: the deflections under the loads of the deflected configuration.

delta = law(load(q + delta)) is solved by Newton's method on all poses of a block at once. The last step is not walked
but carried to first order (`Equilibrium.remainder`): it is so short that its second order is below rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array, Placement, forward
from elastocal.elasticity.coupling import coupled_deflections
from elastocal.elasticity.drive import DriveCurve
from elastocal.elasticity.laws import Law, Load
from elastocal.errors import EquilibriumError
from elastocal.statics import Mechanism, Statics, load, mutual_gradients

LAST_STEP = 1e-4, 2e-7
"""A Newton step shorter than this, relative to the largest deflection and in rad or m, is the last. What it leaves is
second order: in the deflection its square times d2(load) x compliance (1e-2 or less), in position half its square."""

ROUNDING = 1e-15
"""Deflections [rad or m] below this are rounding, as of a joint whose load is zero."""

LARGEST = 0.5
"""A deflection [rad or m] beyond this is no robot's."""

MAX_PASSES = 30


@dataclass(frozen=True)
class Spring:
    """How an element gives way: law, coefficients [rad/(N m)^power or m/N^power], transition torque [N m or N]."""

    law: Law | DriveCurve
    coefficients: tuple[float, ...]
    transition: float | None = None

    def displaced(self, number: int, delta: float) -> Spring:
        """Add to a coefficient by its number; after the last one comes the transition torque."""
        if number == len(self.coefficients):
            return replace(self, transition=(self.transition or 0.0) + delta)
        changed = list(self.coefficients)
        changed[number] += delta
        return replace(self, coefficients=tuple(changed))


@dataclass(frozen=True)
class Equilibrium:
    """A block of poses at rest, with the chain still short of it by `remainder`.

    Attributes:
        statics: the chain under load at deflections - remainder.
        deflections: (elastic, n) of the elements that give way.
        remainder: (elastic, n) the last step, to be carried to first order.
        answers: (elastic, n) deflections by the laws at these loads.
        slopes: (elastic, n) d(deflection)/d(load).
        partials: for each elastic element its law's partial derivatives, (coefficients, n).
        mutual: (elastic, elastic, n) d(load)/d(deflection); empty where the deflections are held.
    """

    statics: Statics
    deflections: Array
    remainder: Array
    answers: Array
    slopes: Array
    partials: list[Array]
    mutual: Array


def settle(
    mechanism: Mechanism,
    placement: Placement,
    springs: tuple[Spring, ...],
    motion: Array,
    wrench: Array | None = None,
    sides: Array | None = None,
) -> Equilibrium:
    """Find the deflections of poses `motion` (moving, n) under gravity and a wrench (6, n) on the tool.

    The side of a law with a transition torque is decided once, from the loads of the undeflected configuration, or from
    loads `sides` (elastic, n) where these are not NaN.

    Raises:
        EquilibriumError: the deflections do not settle; names the element and the pose (its column).
    """
    deflections = np.zeros((len(springs), motion.shape[1]))
    state = at_deflections(mechanism, placement, springs, motion, deflections, wrench, sides)
    decisive = _decisive(state.statics.loads, sides)
    for _ in range(MAX_PASSES):
        mutual = mutual_gradients(state.statics)
        step = coupled_deflections(state.answers - deflections, state.slopes, mutual)
        deflections = deflections + step
        size, scale = np.abs(step), np.abs(deflections).max(axis=1, initial=0.0, keepdims=True)
        if not (scale < LARGEST).all():
            break
        if (size <= np.clip(LAST_STEP[0] * scale, ROUNDING, LAST_STEP[1])).all():
            return replace(state, deflections=deflections, remainder=step, mutual=mutual)
        state = at_deflections(mechanism, placement, springs, motion, deflections, wrench, decisive)
    row, pose = np.unravel_index(int(np.argmax(size)), size.shape)
    raise EquilibriumError(mechanism.chain.elements[mechanism.elastic[row]].name, int(pose))


def at_deflections(
    mechanism: Mechanism,
    placement: Placement,
    springs: tuple[Spring, ...],
    motion: Array,
    deflections: Array,
    wrench: Array | None = None,
    sides: Array | None = None,
) -> Equilibrium:
    """The chain at given deflections (elastic, n); loads `sides` decide the sides of a law where they are not NaN."""
    moved = motion.copy()
    moved[mechanism.elastic_rows] += deflections
    statics = load(mechanism, placement, forward(placement, moved), wrench)
    decisive = _decisive(statics.loads, sides)
    responses = [
        spring.law.respond(spring.coefficients, Load(statics.loads[i], decisive[i], spring.transition or 0.0))
        for i, spring in enumerate(springs)
    ]
    shape = deflections.shape
    return Equilibrium(
        statics=statics,
        deflections=deflections,
        remainder=np.zeros_like(deflections),
        answers=np.array([response.deflection for response in responses]).reshape(shape),
        slopes=np.array([response.compliance for response in responses]).reshape(shape),
        partials=[response.partials for response in responses],
        mutual=np.empty((0, 0, 0)),
    )


def _decisive(loads: Array, sides: Array | None) -> Array:
    return loads if sides is None else np.where(np.isnan(sides), loads, sides)
