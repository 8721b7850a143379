"""Laws of compliance: deflection = sum_k c_k phi_k(load), linear in the coefficients, phi odd."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.chain import Array


class Load(NamedTuple):
    """What a law sees of one element: its load, the load before anything deflected, (n,), and the transition torque."""

    load: Array
    undeflected: Array
    transition: float | None


@dataclass(frozen=True)
class Law:
    """A family of torque-deflection curves.

    Attributes:
        name: as in robot files and options.
        coefficients: their names, in order.
        powers: a coefficient has the unit rad/(N m)^power (m/N^power for translations).
        basis: phi, (coefficients, n).
        slopes: d(phi)/d(load), (coefficients, n).
        transition: whether the law has a transition torque.
    """

    name: str
    coefficients: tuple[str, ...]
    powers: tuple[int, ...]
    basis: Callable[[Load], Array]
    slopes: Callable[[Load], Array]
    transition: bool = False


def _linear_basis(at: Load) -> Array:
    return at.load[None]


def _linear_slopes(at: Load) -> Array:
    return np.ones((1, len(at.load)))


LINEAR = Law("linear", ("c",), (1,), _linear_basis, _linear_slopes)

LAWS = {law.name: law for law in (LINEAR,)}
