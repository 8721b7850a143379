"""Are grossly wrong rows found, and does the fit suffer from them? `python studies/outliers.py`.

Twenty simulated 1.45 m arms each with rigid joints, linear joints, hinges and steps: 60 poses of one target, 0.03 mm
noise per axis, base and tool unknown, and six rows wrong by 5 to 50 mm in any direction. Held-out errors are those of
500 more poses, against a plain fit of the same 54 good rows. "Alone" is the robust fit with its weights, nothing
rejected. The last result is in outliers.txt.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from transition_recovery import JOINTS, NOISE, actual_arm

from elastocal.chain import Array
from elastocal.examples import ROBOT_FILE
from elastocal.identification import calibrate, choose_gauge, fit_frames, residuals
from elastocal.identification.request import requested, with_laws
from elastocal.identification.robust import fit_robustly
from elastocal.io import load_robot
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate

SEEDS = 20
POSES, WRONG, SMALLEST, LARGEST = 60, 6, 5e-3, 50e-3
FAMILIES = ("rigid", "linear", "hinge", "step")


class Outcome(NamedTuple):
    """One calibration beside that of the good rows alone."""

    ratio: float
    named: int
    accused: int
    alone: float
    seconds: float


def actual_of(family: str, seed: int) -> Robot:
    """An arm whose joints 2 and 3 are rigid, linear, hinges or steps."""
    if family in ("hinge", "step"):
        return actual_arm(family, seed)
    actual = actual_arm("hinge", seed)
    linear = {name: Compliance("linear", spring.coefficients[:1]) for name, spring in actual.elastic.items()}
    return replace(actual, elastic=linear if family == "linear" else {})


def spoiled(data: Measurements, rng: np.random.Generator) -> tuple[Measurements, Array]:
    """The data with some rows wrong, and which these are."""
    rows = rng.choice(len(data), WRONG, replace=False)
    directions = rng.standard_normal((WRONG, 3))
    jumps = rng.uniform(SMALLEST, LARGEST, (WRONG, 1)) * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    position = data.position.copy()
    position[rows] += jumps
    return replace(data, position=position), np.sort(rows)


def outcome(family: str, loss: str, seed: int) -> Outcome:
    """Calibrate one arm."""
    actual = actual_of(family, seed)
    clean = simulate(actual, random_poses(actual, POSES, seed), noise=NOISE, seed=seed)
    held_out = simulate(actual, random_poses(actual, 500, seed + 1000))
    data, wrong = spoiled(clean, np.random.default_rng(seed + 7))
    good = np.setdiff1d(np.arange(POSES), wrong)
    nominal, elastic = load_robot(ROBOT_FILE), {} if family == "rigid" else dict.fromkeys(JOINTS, family)
    result = calibrate(nominal, data, elastic=elastic, loss=loss)
    reference = calibrate(nominal, clean.take(good), elastic=elastic)
    errors = [residuals(found.robot, held_out).norms.mean() for found in (result, reference)]
    named = [found.index for found in result.outliers]
    alone = np.nan
    if family in ("rigid", "linear"):
        alone = residuals(robust_alone(nominal, data, elastic, loss), held_out).norms.mean()
    missed = len(np.intersect1d(named, wrong)), len(np.setdiff1d(named, wrong))
    return Outcome(errors[0] / errors[1], *missed, alone / errors[1], result.seconds)


def robust_alone(nominal: Robot, data: Measurements, elastic: dict[str, str], loss: str) -> Robot:
    """The robot by a robust fit of all rows."""
    wished, springs = with_laws(nominal, elastic)
    gauge = choose_gauge(wished, data, requested(wished, springs))
    model = Model(fit_frames(wished, data, gauge), gauge.kept, data)
    return model.displaced(fit_robustly(model, np.zeros(len(gauge.kept)), loss)[1].displacements)


def report(family: str, loss: str) -> str:
    """The outcomes of all seeds."""
    found = [outcome(family, loss, seed) for seed in range(SEEDS)]
    ratios, alone = [o.ratio for o in found], [o.alone for o in found]
    robustly = f"{np.mean(alone):10.3f}{max(alone):8.3f}" if np.isfinite(alone).all() else " " * 18
    return (
        f"{family:8}{loss:8}{np.mean(ratios):8.3f}{max(ratios):8.3f}{sum(o.named for o in found):9d} of {SEEDS * WRONG}"
        f"{sum(o.accused for o in found):9d} of {SEEDS * (POSES - WRONG)}{robustly}"
        f"{1e3 * np.median([o.seconds for o in found]):10.0f} ms"
    )


if __name__ == "__main__":
    print("                 held-out ratio     outliers         good rows     robust fit alone     median")
    print("joints  loss       mean   worst        named           accused       mean   worst        time")
    for family in FAMILIES:
        for loss in ("huber", "cauchy"):
            print(report(family, loss), flush=True)
