"""Are the uncertainties right? `python studies/coverage.py [CALIBRATIONS]`.

200 simulated calibrations each of rigid, linear and hinge 1.45 m arms: 1 mm and 1 mrad of errors on every length and
angle, compliances of joints 2 and 3 that are 2.5 times stiffer above a transition torque (hinge), 60 poses of one
target, 0.03 mm noise per axis, base and tool unknown. Truth is the fit to the same poses without noise, in the same
gauge. Of every parameter, 95 % intervals should cover it in 95 % of the calibrations; the reduced chi-square with the
true noise stated should be 1; and the predicted position should scatter about the true fit's at 200 new poses as its
standard deviation says. The last result is in coverage.txt.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from transition_recovery import actual_arm

from elastocal.examples import ROBOT_FILE
from elastocal.identification import CalibrationResult, calibrate
from elastocal.io import load_robot
from elastocal.measurements import Measurements
from elastocal.prediction import predict
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate
from elastocal.uncertainty import position_uncertainty

CALIBRATIONS, POSES, NEW_POSES, NOISE = 200, 60, 200, 3e-5
LAWS = ("rigid", "linear", "hinge")
ELASTIC = ("2", "3")


@dataclass
class Tally:
    """What the calibrations of one law came to.

    Attributes:
        covered: by parameter, whether its interval covers the truth, one for each calibration.
        linear: the same of transition torques, by their standard deviations instead of the misfit's profile.
        chi2: reduced chi-square with the noise stated, one for each calibration.
        found, expected: squares of the predicted position's errors, and of its standard deviations.
    """

    covered: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    linear: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    chi2: list[float] = field(default_factory=list)
    found: list[float] = field(default_factory=list)
    expected: list[float] = field(default_factory=list)


def arm(law: str, seed: int) -> Robot:
    """An arm with one of the laws on its elastic joints."""
    built = actual_arm("hinge", seed)
    if law == "hinge":
        return built
    linear = {name: Compliance("linear", found.coefficients[:1]) for name, found in built.elastic.items()}
    return replace(built, elastic=linear if law == "linear" else {})


def fitted(law: str, data: Measurements) -> CalibrationResult:
    """The calibration with the law that the arm has."""
    return calibrate(load_robot(ROBOT_FILE), data, elastic={} if law == "rigid" else dict.fromkeys(ELASTIC, law))


def count(tally: Tally, law: str, seed: int) -> None:
    """Add one calibration."""
    actual = arm(law, seed)
    q = random_poses(actual, POSES, seed)
    true = fitted(law, simulate(actual, q))
    result = fitted(law, simulate(actual, q, noise=NOISE, seed=seed + 1))
    values = {p.name: p.identified for p in true.parameters}
    for p in result.parameters:
        if p.interval is not None and p.std is not None:
            low, high = p.interval
            tally.covered[p.name].append(low <= values[p.name] <= high)
            if p.name.endswith("transition_torque"):
                tally.linear[p.name].append(abs(values[p.name] - p.identified) <= 1.976 * p.std)
    squares = np.nansum(result.errors.calibrated.position**2)
    tally.chi2.append(squares / NOISE**2 / result.freedom)
    new = random_poses(actual, NEW_POSES, seed + 10_000)
    errors = predict(result.robot, new)[0] - predict(true.robot, new)[0]
    tally.found.append(float((errors**2).sum(axis=1).mean()))
    tally.expected.append(float((position_uncertainty(result, new).from_parameters ** 2).mean()))


def report(law: str, tally: Tally) -> list[str]:
    """The figures of one law."""
    shares = {name: float(np.mean(found)) for name, found in tally.covered.items()}
    pooled = np.mean([hit for found in tally.covered.values() for hit in found])
    least, most = min(shares, key=lambda name: shares[name]), max(shares, key=lambda name: shares[name])
    ratio = np.sqrt(np.mean(tally.found) / np.mean(tally.expected))
    lines = [
        f"{law}: {len(tally.chi2)} calibrations, {len(shares)} parameters",
        f"  reduced chi-square, mean                         {np.mean(tally.chi2):6.3f}   bar 0.97 to 1.03",
        f"  95 % intervals cover, pooled [%]                 {100 * pooled:6.1f}   bar 93 to 97",
        f"  least, of one parameter [%]                      {100 * shares[least]:6.1f}   bar 90         {least}",
        f"  most, of one parameter [%]                       {100 * shares[most]:6.1f}   bar 99         {most}",
        f"  scatter of the position at new poses / predicted {ratio:6.3f}   bar 0.9 to 1.1",
    ]
    for name, found in tally.linear.items():
        lines.append(f"  {name}: profile {100 * shares[name]:.1f} %, standard deviation {100 * np.mean(found):.1f} %")
    return lines


def main(arguments: Sequence[str]) -> None:
    """Print the figures of all laws."""
    calibrations = int(arguments[0]) if arguments else CALIBRATIONS
    for law in LAWS:
        tally = Tally()
        for seed in range(calibrations):
            count(tally, law, seed)
        print("\n".join(report(law, tally)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
