"""Do priors on geometry help? `python studies/priors.py UR10_FOLDER`, a folder as for joint_maps.py.

Held-out errors (means in mm) of fits of a canonical subset of the geometry and of all of it with estimated tolerances:
simulated arms as in joint_maps.py, errors of 1 mm and 1 mrad, 8 of each number of poses; and random choices of a real
robot's poses. The last result is in priors.txt.
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
from elastocal.measurements import Measurements
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate

POSES = (15, 20, 30, 45, 100)
ARMS, CHOICES = 8, 8


def errors(nominal: Robot, data: Measurements, held_out: Measurements) -> tuple[float, float]:
    """Held-out means without and with priors [mm]."""
    laws = dict.fromkeys(JOINTS, "linear")
    without, with_prior = (
        calibrate(nominal, data, held_out=held_out, elastic=laws, prior=wanted) for wanted in (False, True)
    )
    return 1e3 * without.residuals["held_out"].mean, 1e3 * with_prior.residuals["held_out"].mean


def simulated(poses: int, seed: int) -> tuple[float, float]:
    """One arm with linear joints."""
    drawn = actual_arm("step", seed)
    springs = {name: Compliance("linear", (spring.coefficients[0],)) for name, spring in drawn.elastic.items()}
    actual = replace(drawn, elastic=springs)
    data = simulate(actual, random_poses(actual, poses, seed), noise=NOISE, seed=seed)
    return errors(load_robot(ROBOT_FILE), data, simulate(actual, random_poses(actual, 300, seed + 1000)))


def real(folder: Path, poses: int, seed: int) -> tuple[float, float]:
    """One choice of a real robot's poses, judged by others."""
    robot = load_robot(folder / "robot.toml")
    data = load_measurements([folder / "series_b.toml", folder / "series_c.toml"], robot)
    chosen = np.random.default_rng(seed).permutation(len(data))
    return errors(robot, data.take(chosen[:poses]), data.take(chosen[poses : poses + 1000]))


def told(title: str, found: list[tuple[float, float]]) -> str:
    """One line of both errors."""
    without, with_prior = np.array(found).T
    better = int((with_prior < without).sum())
    means = f"without {without.mean():.4f}, with priors {with_prior.mean():.4f}"
    return f"{title}: {means}, better in {better} of {len(found)}"


if __name__ == "__main__":
    for count in POSES:
        print(told(f"simulated, {count} poses", [simulated(count, seed) for seed in range(ARMS)]), flush=True)
        runs = [real(Path(sys.argv[1]), count, seed) for seed in range(CHOICES)]
        print(told(f"UR10, {count} poses", runs), flush=True)
