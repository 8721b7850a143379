"""Simulated calibrations: an actual robot, what is measured of it, and how far off an identified one is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastocal.identification import Gauge, choose_gauge, residuals
from elastocal.identification.request import requested, with_laws
from elastocal.measurements import Measurements
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate
from support.robots import placed

ALL_LINEAR = {str(i): "linear" for i in range(1, 7)}


def gauge_of(nominal: Robot, kinds: tuple[str, ...], elastic: dict[str, str] | None = None) -> Gauge:
    """The gauge of a robot whose target is measured in some ways."""
    wished, springs = with_laws(nominal, elastic or {})
    probe = simulate(wished, random_poses(wished, 3, 1), kinds=kinds)
    return choose_gauge(wished, probe, requested(wished, springs))


def actual_in_gauge(nominal: Robot, gauge: Gauge, rng: np.random.Generator, size: float = 1e-3) -> Robot:
    """A robot that differs from the nominal one in kept parameters only: geometry by `size`, compliances of 1e-6."""
    groups = {name: parameter.group for name, parameter in parameters_of(nominal).items()}
    compliant = {
        name.removesuffix(".c"): Compliance("linear", (1e-6 * rng.uniform(1.0, 5.0),))
        for name in gauge.kept
        if name.endswith(".c")
    }
    geometry = [name for name in gauge.kept if not name.endswith(".c") and groups[name] not in FRAME_GROUPS]
    moved = nominal.displaced({name: size * rng.standard_normal() for name in geometry})
    return placed(replace(moved, elastic=compliant), rng)


def measured(actual: Robot, count: int, seed: int, **options: object) -> Measurements:
    """Measurements of an actual robot at random poses."""
    return simulate(actual, random_poses(actual, count, seed), seed=seed, **options)


def distances(robot: Robot, data: Measurements) -> NDArray[np.float64]:
    """How far a robot's predictions are from measured positions, (n,)."""
    return residuals(robot, data).norms
