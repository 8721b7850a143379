"""Which rule tells rigid, linear, step and hinge apart? `python studies/model_choice.py`.

Simulated 1.45 m arms of each kind, 60 poses of one target, 0.03 mm noise per axis, base and tool unknown; every model
of `elastocal compare` is fitted to each. The rules weigh the same fits by AIC, AICc, BIC, and BIC with its penalty
times a factor, transition torques counted as parameters. The last result is in model_choice.txt.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from transition_recovery import JOINTS, NOISE, actual_arm

from elastocal.comparison import ComparedModel, Comparison, compare
from elastocal.examples import ROBOT_FILE
from elastocal.io import load_robot
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate

EACH = 20
LARGEST_LOADS = {"2.theta": 800.0, "3.theta": 250.0}
"""Loads [N m] at which the cubic arms are twice as stiff as without load."""

LINEAR = 40
"""Arms of each kind, and linear ones in addition that a nonlinearity must not be claimed of."""

RULES: dict[str, Callable[[ComparedModel], float]] = {
    "AIC": lambda m: m.deviance + 2.0 * m.parameters,
    "AICc": lambda m: m.aicc,
    "BIC": lambda m: m.bic,
    **{
        f"BIC x {factor}": lambda m, factor=factor: m.deviance + factor * m.parameters * np.log(m.coordinates)
        for factor in (1.2, 1.4, 1.6, 2.0, 2.5)
    },
}


def arm(kind: str, seed: int) -> Robot:
    """An actual arm: rigid, or with the law on joints 2 and 3."""
    drawn = actual_arm(kind if kind in ("step", "hinge") else "step", seed)
    if kind == "rigid":
        return replace(drawn, elastic={})
    if kind == "linear":
        springs = {name: Compliance("linear", (spring.coefficients[0],)) for name, spring in drawn.elastic.items()}
        return replace(drawn, elastic=springs)
    if kind == "cubic":
        springs = {}
        for name, spring in drawn.elastic.items():
            soft = spring.coefficients[0]
            springs[name] = Compliance("cubic", (soft, -soft / (6.0 * LARGEST_LOADS[name] ** 2)))
        return replace(drawn, elastic=springs)
    return drawn


def compared(kind: str, seed: int, poses: int = 60) -> Comparison:
    """All models fitted to one arm."""
    actual = arm(kind, seed)
    data = simulate(actual, random_poses(actual, poses, seed), noise=NOISE, seed=seed)
    return compare(load_robot(ROBOT_FILE), data, elastic=tuple(JOINTS), folds=None)


def choices(kind: str, seeds: range) -> dict[str, Counter[str]]:
    """How often each rule chooses which model."""
    counted: dict[str, Counter[str]] = {rule: Counter() for rule in RULES}
    for seed in seeds:
        models = compared(kind, seed).models
        for rule, criterion in RULES.items():
            counted[rule][min(models, key=criterion).name] += 1
    return counted


if __name__ == "__main__":
    runs = {kind: (kind, range(2000, 2000 + EACH)) for kind in ("rigid", "linear", "step", "hinge", "cubic")}
    runs[f"linear, {LINEAR} more"] = ("linear", range(3000, 3000 + LINEAR))
    for title, (kind, seeds) in runs.items():
        print(f"actual: {title}, {len(seeds)} arms")
        for rule, counted in choices(kind, seeds).items():
            listed = ", ".join(f"{name} {count}" for name, count in counted.most_common())
            print(f"  {rule:10} {listed}")
