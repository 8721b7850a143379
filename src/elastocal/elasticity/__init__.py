"""What gives way under load: laws of compliance and the equilibrium they lead to."""

from elastocal.elasticity.coupling import coupled_columns
from elastocal.elasticity.drive import HARMONIC_DRIVE, DriveCurve
from elastocal.elasticity.equilibrium import Equilibrium, Spring, at_deflections, settle
from elastocal.elasticity.laws import CUBIC, HINGE, LAWS, LINEAR, STEP, Law, Load

CURVES: dict[str, Law | DriveCurve] = {**LAWS, HARMONIC_DRIVE.name: HARMONIC_DRIVE}
"""All that a robot file may hold, by name: the laws, and the curve that only an actual robot has."""

__all__ = [
    "CUBIC",
    "CURVES",
    "HARMONIC_DRIVE",
    "HINGE",
    "LAWS",
    "LINEAR",
    "STEP",
    "DriveCurve",
    "Equilibrium",
    "Law",
    "Load",
    "Spring",
    "at_deflections",
    "coupled_columns",
    "settle",
]
