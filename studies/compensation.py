"""How near a compensated robot comes to its targets: `python studies/compensation.py`.

Arms as they might be built (0.5 mm, 0.5 mrad), joints 2 and 3 with hinges, loaded, are calibrated from 45 poses with
0.03 mm of noise, chosen or at random, and sent to 1,000 targets; also with the true parameters, which shows what the
solution itself leaves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

import elastocal as ec
from elastocal.examples import ROBOT_FILE, actual_arm
from elastocal.robot import Compliance, Robot

ARMS, POSES, TARGETS, NOISE = 10, 45, 1000, 3e-5
CANDIDATES = 2000
ELASTIC = {"2": "hinge", "3": "hinge", "4": "linear", "5": "linear"}
HINGES = {"2.theta": ((3.0e-6, 1.8e-6), 0.5), "3.theta": ((5.0e-6, 3.0e-6), 0.5)}
"""Coefficients, and transition torques in parts of the largest load."""


def arm(nominal: Robot, seed: int) -> Robot:
    """The actual robot of a seed."""
    actual = actual_arm(nominal, seed)
    q = ec.random_poses(actual, 500, 0)
    loads = largest_loads(actual, q)
    laws = dict(actual.elastic)
    for element, (coefficients, part) in HINGES.items():
        laws[element] = Compliance("hinge", coefficients, part * loads[element])
    return replace(actual, elastic=laws)


def largest_loads(robot: Robot, q: np.ndarray) -> dict[str, float]:
    """Of each elastic element over poses."""
    from elastocal.prediction.driving import Driver

    driver = Driver.of(robot)
    elements = driver.assembly.mechanism.chain.elements
    names = [elements[i].name for i in driver.assembly.mechanism.elastic]
    return dict(zip(names, np.abs(driver.undeflected_loads(q.T)).max(axis=1).tolist(), strict=True))


def chosen_poses(nominal: Robot, seed: int, planned: bool) -> np.ndarray:
    """Joint positions to measure at."""
    if not planned:
        return ec.random_poses(nominal, POSES, seed)
    candidates = ec.random_poses(nominal, CANDIDATES, seed)
    plan = ec.select_poses(nominal, candidates, count=POSES, elastic=ELASTIC, seed=seed)
    return candidates[plan.rows]


def errors(actual: Robot, q: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """How far the actual robot is from targets in the instrument's frame, (n,)."""
    return np.linalg.norm(ec.predict(actual, q)[0] - positions, axis=1)


def main() -> None:
    """Run all and print a table."""
    nominal = ec.load_robot(ROBOT_FILE)
    found: dict[str, list[np.ndarray]] = {}
    for seed in range(ARMS):
        actual = arm(nominal, seed)
        seated = replace(nominal, base=actual.base, tool=actual.tool)
        goals = ec.predict(seated, ec.random_poses(nominal, TARGETS, 1000 + seed))
        robots = {"true parameters": actual}
        for planned in (False, True):
            data = ec.simulate(actual, chosen_poses(nominal, seed, planned), noise=NOISE, seed=seed)
            robots["45 poses chosen" if planned else "45 poses at random"] = ec.calibrate(
                nominal, data, elastic=ELASTIC
            ).robot
        for name, robot in robots.items():
            result = ec.compensate(robot, goals[0], nominal=nominal, frame="instrument")
            kept = result.reached
            found.setdefault(f"{name}, before", []).append(errors(actual, result.nominal_q, goals[0])[kept])
            found.setdefault(f"{name}, after", []).append(errors(actual, result.q, goals[0])[kept])
    table = Table("robot", "targets reached", "mean [mm]", "worst arm's mean", "95 %", "max", title=f"{ARMS} arms")
    for name, parts in found.items():
        whole = np.concatenate(parts)
        figures = (whole.mean(), max(part.mean() for part in parts), np.quantile(whole, 0.95), whole.max())
        table.add_row(name, str(len(whole)), *(f"{1e3 * value:.3g}" for value in figures))
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
