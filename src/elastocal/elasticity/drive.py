"""The torque-torsion curve of a harmonic drive: for actual robots of simulations, not to be identified."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity.laws import Load, Response

MAX_STEPS = 50


@dataclass(frozen=True)
class DriveCurve:
    """Cubic, linear, and a soft wind-up near zero torque that fades out (nonlinear joint stiffness paper, Eq. (1)).

    torque = a3 x^3 + a1 x - k_sw exp(-a_sw |x|) x at torsion x, with a3 [N m/rad^3], a1 and k_sw [N m/rad] and
    a_sw [1/rad] (after Kircanski and Goldenberg, 1997). Its inverse is the law: deflection at torque.
    """

    name: str = "harmonic-drive"
    coefficients: tuple[str, ...] = ("a3", "a1", "k_sw", "a_sw")
    transition: bool = False

    def torque(self, coefficients: Sequence[float], torsion: Array) -> Array:
        """Torque (n,) [N m] at a torsion (n,) [rad]."""
        a3, a1, k_sw, a_sw = coefficients
        return torsion * (a3 * torsion**2 + a1 - k_sw * np.exp(-a_sw * np.abs(torsion)))

    def stiffness(self, coefficients: Sequence[float], torsion: Array) -> Array:
        """d(torque)/d(torsion), (n,) [N m/rad]."""
        a3, a1, k_sw, a_sw = coefficients
        size = np.abs(torsion)
        return 3.0 * a3 * torsion**2 + a1 - k_sw * np.exp(-a_sw * size) * (1.0 - a_sw * size)

    def respond(self, coefficients: Sequence[float], at: Load) -> Response:
        """The element's answer to its load: Newton's method on the curve, each torsion kept within bounds."""
        _, a1, k_sw, _ = coefficients
        low, high = np.zeros_like(at.load), np.abs(at.load) / (a1 - k_sw)  # the curve is softest at zero
        torsion = np.minimum(high, np.abs(at.load) / a1)
        for _ in range(MAX_STEPS):
            excess = self.torque(coefficients, torsion) - np.abs(at.load)
            low, high = np.where(excess < 0.0, torsion, low), np.where(excess > 0.0, torsion, high)
            following = torsion - excess / self.stiffness(coefficients, torsion)
            following = np.where((following < low) | (following > high), 0.5 * (low + high), following)
            settled = (np.abs(following - torsion) <= 1e-15 + 1e-14 * torsion).all()
            torsion = following
            if settled:
                break
        torsion = np.copysign(torsion, at.load)
        return Response(torsion, 1.0 / self.stiffness(coefficients, torsion), np.empty((0, len(torsion))))


HARMONIC_DRIVE = DriveCurve()
