"""What gives way under load: laws of compliance and the equilibrium they lead to."""

from elastocal.elasticity.coupling import coupled_columns
from elastocal.elasticity.equilibrium import Equilibrium, Spring, at_deflections, settle
from elastocal.elasticity.laws import LAWS, LINEAR, Law, Load

__all__ = [
    "LAWS",
    "LINEAR",
    "Equilibrium",
    "Law",
    "Load",
    "Spring",
    "at_deflections",
    "coupled_columns",
    "settle",
]
