"""The built-in example: a nominal arm, and an actual one that differs from it and gives way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.measurements import Measurements
from elastocal.robot import Compliance, Frame, Robot
from elastocal.simulation import Region, random_poses, simulate, with_geometry_errors

ROBOT_FILE = Path(__file__).with_name("arm.toml")

NOISE = 3e-5
"""Standard deviation of each measured coordinate [m]."""

COMPLIANCE = {"2.theta": 2.0e-6, "3.theta": 3.5e-6, "4.theta": 1.2e-5, "5.theta": 2.0e-5}
"""Of the actual arm's joints [rad/(N m)]."""

HINGES = {"2.theta": Compliance("hinge", (5e-6, 2e-6), 250.0), "3.theta": Compliance("hinge", (8e-6, 3.5e-6), 80.0)}
"""Of an arm whose joints stiffen as their load grows: in the place of the linear ones."""

TARGET = Frame((0.08, -0.05, 0.17), known=True)
"""flange_T_tool of the actual arm."""

FLOOR = 0.2
"""No measured pose brings the target below this height [m]."""


def actual_arm(nominal: Robot, seed: int = 0) -> Robot:
    """An arm as it might have been built and set up: geometry off by about 0.5 mm and 0.5 mrad, compliant joints.

    The instrument stands three metres away, and the target sits somewhere on the tool.
    """
    set_up = with_geometry_errors(nominal, 5e-4, 5e-4, seed).with_frames(
        {
            "base": Frame((2.6, -1.4, -0.7), (0.01, -0.02, 2.1), known=True),
            "tool": TARGET,
        }
    )
    elastic = {name: Compliance("linear", (value,)) for name, value in COMPLIANCE.items()}
    return replace(set_up, elastic=elastic)


def measure(actual: Robot, count: int, seed: int = 0) -> Measurements:
    """Measure positions of an actual arm at random poses above the floor."""
    rng = np.random.default_rng(seed)
    q = random_poses(actual, count, rng, region=Region(floor=FLOOR))
    return simulate(actual, q, noise=NOISE, seed=rng)


def stiffening_arm(nominal: Robot, seed: int = 0) -> Robot:
    """The actual arm with joints 2 and 3 that stiffen from a transition torque on."""
    actual = actual_arm(nominal, seed)
    return replace(actual, elastic={**actual.elastic, **HINGES})
