"""Units: known here and nowhere below."""

from __future__ import annotations

import math
import re

from elastocal.errors import InputError, unknown_name

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

_NUMBER = re.compile(r"\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>.*?)\s*")


def factor(quantity: str, unit: str | None) -> float | None:
    """The factor that turns a unit into SI; 1 without a unit; None if the quantity does not know the unit."""
    return 1.0 if unit is None else UNITS[quantity].get(unit)


def parse_quantity(text: str, quantity: str) -> float:
    """A number with a unit, as "0.03mm" or "0.1 deg", in SI; without a unit it is SI already.

    Raises:
        InputError: it is no finite number, or the quantity does not know the unit.
    """
    found = _NUMBER.fullmatch(text)
    if found is None or not math.isfinite(float(found["number"])):
        units = ", ".join(UNITS[quantity])
        raise InputError(f"expected a number and a unit of {quantity} ({units}; none: {SI[quantity]}), found {text!r}")
    scale = factor(quantity, found["unit"] or None)
    if scale is None:
        raise InputError(unknown_name(f"{quantity} unit", found["unit"], UNITS[quantity]))
    return float(found["number"]) * scale
