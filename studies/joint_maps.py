"""What joint maps gain on a real robot, and what they cost on one without transmission error.

`python studies/joint_maps.py UR10_FOLDER`, a folder with robot.toml, series_b.toml and series_c.toml. Held-out errors
are means in mm; the simulated arms are those of transition_recovery.py with linear joints, measured at 60 poses. The
last result is in joint_maps.txt.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from transition_recovery import JOINTS, NOISE, actual_arm

from elastocal.examples import ROBOT_FILE
from elastocal.identification import calibrate
from elastocal.io import load_measurements, load_robot
from elastocal.robot import Compliance
from elastocal.simulation import random_poses, simulate

ELASTIC = {"2": "linear", "3": "linear"}
FITTED = {45: 5, 100: 5, 200: 5, 3000: 2}
"""Poses to fit, and how many random choices of them."""

ARMS = 20
ORDERS = 60


def real(folder: Path) -> None:
    """Held-out errors of the UR10 without and with maps."""
    robot = load_robot(folder / "robot.toml")
    data = load_measurements([folder / "series_b.toml", folder / "series_c.toml"], robot)
    for count, seeds in FITTED.items():
        found = []
        for seed in range(seeds):
            for orders in (0, ORDERS, "auto"):
                share = 1.0 - count / len(data)
                result = calibrate(robot, data, holdout=share, seed=seed, elastic=ELASTIC, transmission=orders)
                found.append((1e3 * result.residuals["held_out"].mean, result.seconds))
        errors, seconds = np.array(found).reshape(seeds, 3, 2).transpose(2, 1, 0)
        listed = ", ".join(
            f"{name} {e.mean():.4f} (worst {e.max():.4f}, {s.mean():.1f} s)"
            for name, e, s in zip(("no maps", f"{ORDERS} orders", "auto"), errors, seconds, strict=True)
        )
        print(f"UR10, {count} of {len(data)} poses fitted, {seeds} choices: {listed}", flush=True)


def simulated() -> None:
    """Held-out errors of arms without transmission error, with maps over those without."""
    ratios = []
    for seed in range(ARMS):
        drawn = actual_arm("step", seed)
        springs = {name: Compliance("linear", (spring.coefficients[0],)) for name, spring in drawn.elastic.items()}
        actual = replace(drawn, elastic=springs)
        data = simulate(actual, random_poses(actual, 60, seed), noise=NOISE, seed=seed)
        held_out = simulate(actual, random_poses(actual, 500, seed + 1000))
        laws = dict.fromkeys(JOINTS, "linear")
        errors = [
            calibrate(load_robot(ROBOT_FILE), data, held_out=held_out, elastic=laws, transmission=orders)
            .residuals["held_out"]
            .mean
            for orders in (0, ORDERS)
        ]
        ratios.append(errors[1] / errors[0])
    mean, worst = 100.0 * (np.mean(ratios) - 1.0), 100.0 * (max(ratios) - 1.0)
    print(f"{ARMS} arms without transmission error: maps of {ORDERS} orders cost {mean:.2f} % of the held-out error on")
    print(f"average, {worst:.2f} % at worst", flush=True)


if __name__ == "__main__":
    simulated()
    real(Path(sys.argv[1]))
