"""Does the search find the transition torques? `python studies/transition_recovery.py`.

Twenty simulated 1.45 m arms, whose joints 2 and 3 are 2.5 times stiffer above 250-450 and 60-120 N m, by a step and by
a hinge: 60 poses of one target, 0.03 mm noise per axis, base and tool unknown. Held-out errors are those of 500 more
poses, against a fit of the true structure with the true transition torques; for the step, of the poses whose loads lie
outside the data's gaps. The last result is in transition_recovery.txt.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from elastocal.examples import ROBOT_FILE
from elastocal.identification import CalibrationResult, calibrate, residuals
from elastocal.io import load_robot
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Frame, Robot
from elastocal.simulation import random_poses, simulate, with_geometry_errors

SEEDS = 20
NOISE = 3e-5
JOINTS = {"2": (250.0, 450.0, 1.5e-6, 3e-6), "3": (60.0, 120.0, 3e-6, 6e-6)}
"""By joint: range of transition torques [N m], and of the compliance above them [rad/(N m)]."""
STIFFENING = 2.5


class Outcome(NamedTuple):
    """One calibration beside the truth."""

    same_sides: bool
    ratio: float
    torque_errors: tuple[float, ...]
    deviations: tuple[float, ...]
    search_seconds: float
    seconds: float


def actual_arm(law: str, seed: int) -> Robot:
    """An arm with 1 mm and 1 mrad of errors, anywhere in front of the instrument, any tool."""
    rng = np.random.default_rng(seed)
    nominal = load_robot(ROBOT_FILE)
    flawed = with_geometry_errors(nominal, 1e-3, 1e-3, rng)
    base = Frame(tuple(rng.uniform(-3.0, 3.0, 3)), tuple(rng.uniform(-np.pi, np.pi, 3)), known=True)
    tool = Frame(tuple(rng.uniform(-0.2, 0.2, 3)), tuple(rng.uniform(-1.0, 1.0, 3)), known=True)
    springs = {}
    for joint, (lowest, highest, stiff, soft) in JOINTS.items():
        above, torque = rng.uniform(stiff, soft), rng.uniform(lowest, highest)
        springs[f"{joint}.theta"] = Compliance(law, (STIFFENING * above, above), torque)
    return replace(flawed, base=base, tool=tool, elastic=springs)


def loads(robot: Robot, data: Measurements) -> dict[str, np.ndarray]:
    """Sizes of the loads of the undeflected robot."""
    return {name: np.abs(found) for name, found in Model(robot, (), data).undeflected_loads(np.zeros(0)).items()}


def known_sides(result: CalibrationResult, actual: Robot, held_out: Measurements) -> np.ndarray:
    """Held-out rows whose loads lie outside the data's gaps."""
    known = np.ones(len(held_out), dtype=bool)
    for element in result.elastic:
        low, high = element.transition.gap
        found = loads(actual, held_out)[element.element]
        known &= (found <= low) | (found >= high)
    return known


def outcome(law: str, seed: int, poses: int = 60) -> Outcome:
    """Calibrate one arm."""
    actual = actual_arm(law, seed)
    data = simulate(actual, random_poses(actual, poses, seed), noise=NOISE, seed=seed)
    held_out = simulate(actual, random_poses(actual, 500, seed + 1000))
    nominal, elastic = load_robot(ROBOT_FILE), dict.fromkeys(JOINTS, law)
    result = calibrate(nominal, data, elastic=elastic)
    torques = [spring.transition_torque for spring in actual.elastic.values()]
    reference = calibrate(nominal, data, elastic=elastic, transition=torques)
    rows = known_sides(result, actual, held_out) if law == "step" else np.ones(len(held_out), dtype=bool)
    errors = [residuals(found.robot, held_out).norms[rows].mean() for found in (result, reference)]
    before, after = loads(actual, data), loads(result.robot, data)
    same = all(
        np.array_equal(before[name] >= spring.transition_torque, after[name] >= found.transition_torque)
        for (name, spring), found in zip(actual.elastic.items(), result.elastic, strict=True)
    )
    misses = tuple(e.transition_torque / t - 1.0 for e, t in zip(result.elastic, torques, strict=True))
    scaled = tuple((e.transition_torque - t) / e.transition_std for e, t in zip(result.elastic, torques, strict=True))
    return Outcome(same, errors[0] / errors[1], misses, scaled, result.search.seconds, result.seconds)


def report(law: str) -> list[str]:
    """The outcomes of all seeds."""
    lines = [f"{law}", "seed  sides  held-out ratio   torque 2   torque 3   (in its std)    search    calibrate"]
    found = [outcome(law, seed) for seed in range(SEEDS)]
    for seed, o in enumerate(found):
        misses = "".join(f"{100 * miss:9.1f} %" for miss in o.torque_errors)
        deviations = "".join(f"{d:7.1f}" for d in o.deviations)
        sides = "same" if o.same_sides else "-"
        lines.append(
            f"{seed:4d}  {sides:5}  {o.ratio:14.3f}{misses}  {deviations}"
            f"{1e3 * o.search_seconds:8.0f} ms{1e3 * o.seconds:8.0f} ms"
        )
    ratios = [o.ratio for o in found]
    lines.append(
        f"same sides in {sum(o.same_sides for o in found)} of {SEEDS}; held-out ratio mean {np.mean(ratios):.3f}, "
        f"worst {max(ratios):.3f}; search at most {1e3 * max(o.search_seconds for o in found):.0f} ms\n"
    )
    return lines


if __name__ == "__main__":
    for name in ("step", "hinge"):
        print("\n".join(report(name)))
