"""Derivatives against central differences, for every kind of column."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def central_difference(function: Callable[[float], Array], step: float) -> Array:
    """Derivative at zero, to fourth order in the step."""
    inner = (function(step) - function(-step)) / (2.0 * step)
    outer = (function(2.0 * step) - function(-2.0 * step)) / (4.0 * step)
    return (4.0 * inner - outer) / 3.0
