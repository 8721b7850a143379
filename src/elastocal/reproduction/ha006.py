"""A simulated HA006: the printed table, errors drawn by seed, and joints 2 and 3 after the paper's Eq. (1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import pi

import numpy as np

from elastocal.elasticity import HARMONIC_DRIVE
from elastocal.measurements import Measurements, concatenate
from elastocal.parameters import parameters_of
from elastocal.reproduction.printed import Cells, Link, read_tables, si_values, table_robot, unmarked
from elastocal.reproduction.values import Chosen, Paper, Slip
from elastocal.robot import Compliance, Payload, Robot
from elastocal.simulation import Region, random_poses, simulate

SEED = 0

CORRECTED = {"6.alpha": pi / 2.0}
"""Where the print is not followed [rad]."""

LINKS = {
    "1": Link(limits=(-170.0, 170.0)),
    "2": Link(26.0, (0.24, 0.0, 0.05), (0.0, 150.0)),
    "3": Link(22.0, (0.06, 0.0, 0.0), (-70.0, 90.0)),
    "4": Link(12.0, (0.0, 0.0, -0.30), (-180.0, 180.0)),
    "5": Link(3.5, (0.0, 0.0, 0.0), (-130.0, 130.0)),
    "6": Link(0.8, (0.0, 0.0, -0.02), (-180.0, 180.0)),
}
PAYLOAD = Payload(6.0, (0.0, 0.0, 0.06))

DRIVES = {"2": (3.1e9, 1.55e5, 0.80e5, 500.0), "3": (1.2e10, 1.00e5, 0.52e5, 500.0)}
"""a3 [N m/rad^3], a1 [N m/rad], k_sw [N m/rad] and a_sw [1/rad] of joints 2 and 3."""

GEOMETRY = 7e-4
"""Standard deviation of the actual robot's errors, in each identified parameter [m or rad]."""

NOISE = 5e-5
"""Standard deviation of each measured coordinate [m]."""

FLOOR = 0.2
"""No measured pose brings the tool below this height [m]."""

CALIBRATION_POSES, MORE_POSES = 45, 50

PAPER = Paper(
    "nonlinear-joint-stiffness",
    "Nonlinear joint stiffness, HA006",
    chosen=(
        Chosen(
            "measurements",
            "of a simulated HA006, drawn by a seed (--seed): the first one, 0",
            "the paper's are not published, so its table can be had again in kind only",
        ),
        Chosen(
            "geometric errors",
            "0.7 mm and 0.7 mrad (standard deviation) in each parameter that the paper identifies",
            "so that the error before calibration is about the paper's 3.5 mm, on average over seeds",
        ),
        Chosen(
            "joints 2 and 3",
            "Eq. (1) with a_f1 = 3.1e9 and 1.2e10 N·m/rad³, a_f2 = 1.55e5 and 1.0e5 N·m/rad, "
            "K_sw = -k exp(-500 |q|) with k = 0.8e5 and 0.52e5 N·m/rad",
            "the paper gives no coefficients; with these joint 2 stiffens from 0.8e5 to 2.2e5 N·m/rad and joint 3 from "
            "0.5e5 to 1.5e5 over the loads that occur, and linear calibration leaves more than the paper's 0.115 mm",
        ),
        Chosen(
            "link masses",
            "26, 22, 12, 3.5 and 0.8 kg for rows 2 to 6",
            "not published; usual for an arm of this reach, they load joint 2 with up to 420 N·m, joint 3 with 120",
        ),
        Chosen("payload", "6 kg, 60 mm in front of the flange", "the arm's rated payload"),
        Chosen(
            "poses",
            "45 to calibrate and 50 more, at random within the joints' limits and 0.2 m above the floor",
            "the paper gives their number only",
        ),
        Chosen(
            "a and alpha of row 6",
            "left at their nominal values",
            "with row T as printed, all zero, the tool point lies on the axis of joint 6, where they move it as theta "
            "and d of row 5 do",
        ),
        Chosen(
            "genetic algorithm",
            "30 combinations, 20 generations (--population, --generations)",
            "the paper gives no settings; these find what the exact search finds",
        ),
        Chosen("noise", "0.05 mm per axis (standard deviation)", "that of a laser tracker on an arm of this size"),
    ),
    slips=(
        Slip("Table 1, alpha of row 6", "0", "90 degrees: with 0 the axes of joints 5 and 6 would be parallel"),
        Slip("below Table 1", "lenth", "length"),
    ),
)


@dataclass(frozen=True)
class Experiment:
    """Robots and measurements.

    Attributes:
        nominal: Table 1.
        actual: simulated.
        calibration: 45 poses.
        evaluation: these and 50 more.
    """

    nominal: Robot
    actual: Robot
    calibration: Measurements
    evaluation: Measurements

    @property
    def actual_values(self) -> dict[str, float]:
        """The actual robot's geometry by parameter name; SI."""
        return {name: parameter.nominal or 0.0 for name, parameter in parameters_of(self.actual).items()}


@cache
def printed_table() -> Cells:
    """Table 1 as printed."""
    return read_tables("ha006_table.csv")[""]


def identified_names() -> tuple[str, ...]:
    """The parameters that the paper identifies: those printed without a mark."""
    return unmarked(printed_table())


def nominal_robot() -> Robot:
    """Table 1, with masses."""
    return table_robot("HA006", si_values(printed_table()) | CORRECTED, LINKS, PAYLOAD)


def actual_robot(rng: np.random.Generator) -> Robot:
    """An HA006 as it might have been built: errors in what the paper identifies, joints 2 and 3 that stiffen."""
    names = identified_names()
    deltas = dict(zip(names, (GEOMETRY * rng.standard_normal(len(names))).tolist(), strict=True))
    drives = {f"{joint}.theta": Compliance(HARMONIC_DRIVE.name, found) for joint, found in DRIVES.items()}
    return replace(nominal_robot().displaced(deltas), name="actual HA006", elastic=drives)


def experiment(seed: int = SEED) -> Experiment:
    """Build an HA006 and measure it: all drawn by the seed."""
    rng = np.random.default_rng(seed)
    nominal, actual = nominal_robot(), actual_robot(rng)
    above = Region(floor=FLOOR)
    fitted, more = (
        simulate(actual, random_poses(nominal, count, rng, region=above), noise=NOISE, seed=rng)
        for count in (CALIBRATION_POSES, MORE_POSES)
    )
    return Experiment(nominal, actual, fitted, concatenate([fitted, more]))
