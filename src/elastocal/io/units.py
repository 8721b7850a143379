"""Units: known here and nowhere below."""

from __future__ import annotations

import math

UNITS = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "in": 0.0254},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3, "°": math.pi / 180.0},
    "force": {"N": 1.0, "kN": 1e3},
    "moment": {"N·m": 1.0, "N m": 1.0, "Nm": 1.0, "N·mm": 1e-3, "Nmm": 1e-3},
    "temperature": {"degC": 1.0, "°C": 1.0},
    "none": {"": 1.0, "1": 1.0},
}
"""Factors to SI, by quantity and unit."""

SI = {"length": "m", "angle": "rad", "force": "N", "moment": "N·m", "temperature": "degC", "none": ""}


def factor(quantity: str, unit: str | None) -> float | None:
    """The factor that turns a unit into SI; 1 without a unit; None if the quantity does not know the unit."""
    return 1.0 if unit is None else UNITS[quantity].get(unit)
