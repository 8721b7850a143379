"""Do planned poses predict as well as more random ones? `python studies/planned_poses.py [REPEATS [LAW…]]`.

The built-in example arm as it might have been built (0.5 mm, 0.5 mrad), a new one in each repeat: rigid, with linear
joints 2 to 5, and with hinges in joints 2 and 3 (torques searched) and linear joints 4 and 5. It is planned for as
nominal and rigid, by the criterion accuracy; nobody knows where the instrument stands, and where the target sits on
the tool to some 5 mm, or not at all; 0.03 mm noise per axis. Error: root mean square distance of predicted and true
positions, at 500 poses all over the joint limits and over all repeats [mm]. Expected: what the plan says. The last
result is in planned_poses.txt.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from elastocal.design import Plan, Surroundings, draw_candidates, select_poses
from elastocal.examples import NOISE, ROBOT_FILE, actual_arm
from elastocal.identification import calibrate
from elastocal.io import load_robot
from elastocal.prediction import predict
from elastocal.robot import Compliance, Frame, Robot
from elastocal.simulation import random_poses, simulate

REPEATS, JUDGED = 200, 500

LINEAR = dict.fromkeys(("2", "3", "4", "5"), "linear")
LAWS = {"rigid": {}, "linear": LINEAR, "hinge": {**LINEAR, "2": "hinge", "3": "hinge"}}

HINGES = {"2.theta": Compliance("hinge", (5e-6, 2e-6), 250.0), "3.theta": Compliance("hinge", (8e-6, 3.5e-6), 80.0)}

PAIRS = ((20, 30), (45, 60))


def built(nominal: Robot, law: str, seed: int) -> Robot:
    """An actual arm."""
    actual = actual_arm(nominal, seed)
    elastic = {"rigid": {}, "linear": actual.elastic, "hinge": {**actual.elastic, **HINGES}}[law]
    return replace(actual, elastic=elastic)


def with_guess(nominal: Robot) -> Robot:
    """The nominal robot with a first guess of where the target sits."""
    return replace(nominal, tool=Frame((0.075, -0.045, 0.165)))


def squared_error(nominal: Robot, law: str, q: np.ndarray, judged: np.ndarray, seed: int) -> float:
    """Of one calibration, mean over the judged poses [m2]."""
    actual = built(nominal, law, seed)
    data = simulate(actual, q, noise=NOISE, seed=10_000 + seed)
    found = calibrate(nominal, data, elastic=LAWS[law]).robot
    return float(((predict(found, judged)[0] - predict(actual, judged)[0]) ** 2).sum(axis=1).mean())


def actual_error(nominal: Robot, law: str, poses: list[np.ndarray], judged: np.ndarray) -> float:
    """Root mean square over all repeats [mm]."""
    return 1e3 * float(np.sqrt(np.mean([squared_error(nominal, law, q, judged, s) for s, q in enumerate(poses)])))


def random_expected(plan: Plan, count: int) -> float:
    """What the plan says of so many random poses [mm]."""
    return 1e3 * next(point.random or np.nan for point in plan.curve if point.poses == count)


def main() -> None:
    """Print expected and actual errors of planned and of random poses."""
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else REPEATS
    nominal = load_robot(ROBOT_FILE)
    judged = random_poses(nominal, JUDGED, 99)
    offered = draw_candidates(nominal, 10_000, 60, Surroundings()).poses
    table = Table("law", "tool guess", "planned", "expected", "actual", "random", "expected", "actual", "ratio")
    for law in sys.argv[2:] or LAWS:
        scattered = {
            many: actual_error(nominal, law, [random_poses(nominal, many, 500 + s) for s in range(repeats)], judged)
            for _, many in PAIRS
        }
        for guess, robot in (("5 mm", with_guess(nominal)), ("none", nominal)):
            for few, many in PAIRS:
                plan = select_poses(robot, offered, few, elastic=LAWS[law], criterion="accuracy")
                error = actual_error(nominal, law, [plan.q] * repeats, judged)
                expected = (f"{1e3 * (plan.accuracy or np.nan):.4f}", f"{random_expected(plan, many):.4f}")
                ratio = f"{error / scattered[many]:.3f}"
                planned = (str(few), expected[0], f"{error:.4f}")
                row = (law, guess, *planned, str(many), expected[1], f"{scattered[many]:.4f}", ratio)
                table.add_row(*row)
                print(*row, file=sys.stderr, flush=True)
    Console(width=100).print(f"{repeats} calibrations each", table)


if __name__ == "__main__":
    main()
