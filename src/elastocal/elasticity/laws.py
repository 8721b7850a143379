"""Laws of compliance: how an element's deflection follows from its load.

All but one are linear in their coefficients, deflection = sum_k c_k phi_k(load) with phi odd, and so can be identified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.chain import Array


class Load(NamedTuple):
    """What a law sees of an element: load (n,), the load that decides the side (n,), transition torque (0 if none)."""

    load: Array
    decisive: Array
    transition: float


class Response(NamedTuple):
    """An element's answer to its load.

    Attributes:
        deflection: (n,) [rad or m].
        compliance: (n,) d(deflection)/d(load).
        partials: (coefficients, n) d(deflection)/d(coefficient), and one more row for the transition torque where the
            deflection follows it smoothly.
    """

    deflection: Array
    compliance: Array
    partials: Array


@dataclass(frozen=True)
class Law:
    """A family of torque-deflection curves.

    Attributes:
        name: as in robot files and options.
        coefficients: their names, in order.
        powers: a coefficient has the unit rad/(N m)^power (m/N^power for translations).
        basis: phi, (coefficients, n).
        slopes: d(phi)/d(load), (coefficients, n).
        transition: whether the law has a transition torque. Then its two basis functions add up to the load.
        transition_slopes: d(phi)/d(transition torque), (coefficients, n); None where the curve jumps.
    """

    name: str
    coefficients: tuple[str, ...]
    powers: tuple[int, ...]
    basis: Callable[[Load], Array]
    slopes: Callable[[Load], Array]
    transition: bool = False
    transition_slopes: Callable[[Load], Array] | None = None

    def respond(self, coefficients: Sequence[float], at: Load) -> Response:
        """The element's answer to its load."""
        partials = self.basis(at)
        deflection = np.matmul(coefficients, partials)
        if self.transition_slopes is not None:
            partials = np.vstack([partials, np.matmul(coefficients, self.transition_slopes(at))])
        return Response(deflection, np.matmul(coefficients, self.slopes(at)), partials)


def _linear_basis(at: Load) -> Array:
    return at.load[None]


def _linear_slopes(at: Load) -> Array:
    return np.ones((1, len(at.load)))


LINEAR = Law("linear", ("c",), (1,), _linear_basis, _linear_slopes)
"""Joint stiffness analysis paper: compliance c = 1/K."""


def _sides(at: Load) -> Array:
    high = np.abs(at.decisive) >= at.transition
    return np.stack([~high, high]).astype(float)


def _step_basis(at: Load) -> Array:
    return at.load * _sides(at)


STEP = Law("step", ("c_low", "c_high"), (1, 1), _step_basis, _sides, transition=True)
"""Nonlinear joint stiffness paper, Fig. 1 and Eq. (2): C_L below the transition torque, C_H above it."""


def _hinge_basis(at: Load) -> Array:
    below = np.clip(at.load, -at.transition, at.transition)
    return np.stack([below, at.load - below])


def _hinge_slopes(at: Load) -> Array:
    high = np.abs(at.load) >= at.transition
    return np.stack([~high, high]).astype(float)


def _hinge_transition_slopes(at: Load) -> Array:
    moved = np.sign(at.load) * (np.abs(at.load) >= at.transition)
    return np.stack([moved, -moved])


HINGE = Law("hinge", ("c_low", "c_high"), (1, 1), _hinge_basis, _hinge_slopes, True, _hinge_transition_slopes)
"""Piecewise-linear compliance, the continuous form of the step."""


def _cubic_basis(at: Load) -> Array:
    return np.stack([at.load, at.load**3])


def _cubic_slopes(at: Load) -> Array:
    return np.stack([np.ones_like(at.load), 3.0 * at.load**2])


CUBIC = Law("cubic", ("c1", "c3"), (1, 3), _cubic_basis, _cubic_slopes)
"""Smooth hardening (c3 < 0) or softening."""

LAWS = {law.name: law for law in (LINEAR, STEP, HINGE, CUBIC)}
"""The laws that can be identified, by name."""
