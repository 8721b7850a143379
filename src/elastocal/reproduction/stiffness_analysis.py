"""The paper on joint stiffness analysis: a simulated arm under a heavy payload, calibrated rigid and compliant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from elastocal.chain import Array
from elastocal.identification import CalibrationResult, calibrate
from elastocal.measurements import Measurements
from elastocal.reproduction.printed import HERE, Cells, Link, differing, read_tables, si_values, table_robot
from elastocal.reproduction.values import Chosen, Figures, Paper, ParameterRow, Slip, StiffnessRow
from elastocal.robot import Compliance, Payload, Robot
from elastocal.simulation import simulate

LINKS = {
    "2": Link(17.4, (0.068, 0.006, -0.016)),
    "3": Link(4.8, (0.0, -0.07, 0.014)),
    "4": Link(0.82, (0.0, 0.0, -0.019)),
    "5": Link(0.34, (0.0, 0.0, 0.0)),
    "6": Link(0.09, (0.0, 0.0, 0.032)),
}
PAYLOAD = Payload(20.0)
STIFFNESS = {"2": 1.0285e6, "3": 0.3048e6, "4": 0.3639e6, "5": 0.1740e6, "6": 0.0381e6}
"""Of the actual robot's joints [N m/rad]."""

ROUNDING = 1e-7
"""The measured coordinates are multiples of this [m]."""

DEFLECTING = {"A": ("2", "3", "4", "5", "6"), "B": ("2", "3")}
"""Which joints of the actual robot give way, by set of measurements."""


@dataclass(frozen=True)
class Case:
    """One of the paper's results.

    Attributes:
        name: as printed.
        elastic: joints whose compliance is identified.
        paper: its errors as printed.
    """

    name: str
    elastic: tuple[str, ...]
    paper: Figures

    @property
    def data(self) -> str:
        """The set of measurements, "A" or "B"."""
        return self.name[0].upper()

    @property
    def deflecting(self) -> tuple[str, ...]:
        """Joints of the actual robot that give way."""
        return DEFLECTING[self.data]


CASES = (
    Case("A-1", (), Figures(7.1332e-5, 1.969e-4)),
    Case("a-1", ("2", "3", "4", "5", "6"), Figures(5.5484e-8, 1.4578e-7)),
    Case("a-2", ("2", "3"), Figures(8.8035e-6, 1.9298e-5)),
    Case("a-3", ("3", "4"), Figures(3.2404e-5, 9.0907e-5)),
    Case("a-4", ("4", "5"), Figures(7.0256e-5, 1.7826e-4)),
    Case("a-5", ("2", "4"), Figures(7.2118e-5, 1.7813e-4)),
    Case("B-1", (), Figures(6.8953e-5, 1.9625e-4)),
    Case("b-1", ("2", "3"), Figures(5.0403e-8, 1.3584e-7)),
    Case("b-2", ("2", "3", "4", "5", "6"), Figures(2.8536e-6, 4.9749e-6)),
)

PRINTED_STIFFNESS = {"b-2": {"4": -49.598e6, "5": -2769.6e6}}
"""The only stiffnesses that the paper prints [N m/rad]."""

PAPER = Paper(
    "joint-stiffness-analysis",
    "Joint stiffness analysis",
    chosen=(
        Chosen(
            "poses",
            "20, in stiffness_analysis_poses.csv",
            "the paper says that there are 20 and no more; these are random ones",
        ),
        Chosen(
            "link masses",
            "17.4, 4.8, 0.82, 0.34 and 0.09 kg for rows 2 to 6",
            "those published for the PUMA 560, an arm of nearly these dimensions; so are their centres",
        ),
        Chosen("payload", "20 kg at the origin of frame 7", 'the paper says "fairly heavy"'),
        Chosen("gravity", "9.81 m/s² along -z of the first frame", "the arm stands upright"),
        Chosen(
            "stiffness of joints 2 to 6",
            "1.0285, 0.3048, 0.3639, 0.1740 and 0.0381 million N·m/rad",
            "with these and the poses kinematic calibration leaves about the paper's errors in cases A-1 and B-1",
        ),
        Chosen(
            "rounding of the measured coordinates",
            "0.1 µm",
            "exact coordinates would leave no error at all in a-1 and b-1; the paper's 0.05 µm is that of rounding",
        ),
        Chosen(
            "identified parameters", "the 26 in which Tables 1 and 2 differ", "the text says 24 and does not name them"
        ),
    ),
    slips=(
        Slip("section 3.1", "24 parameters", "26: so many differ between Tables 1 and 2, and so many are found"),
        Slip("section 3.2", "0.007 mm on average for A-1", "0.07 mm, as its table says"),
        Slip("Result A-1, beta of row 1", "0.07257", "0.017257 or nearly so, as in B-1 and a-5"),
        Slip("Result a-2, all parameters", "those of a-1 to the last digit", "others: the error is 160 times larger"),
        Slip("Result a-4, alpha of row 5", "-1.5882", "1.5882"),
        Slip(
            "Result b-1, all parameters",
            "such as a-5's, 2 % off",
            "Table 1's: with them alone the error is 0.00005 mm",
        ),
        Slip("Result b-2, stiffness", "N/rad", "N·m/rad"),
        Slip(
            "Result b-2, errors",
            "0.0029 mm, 57 times b-1's",
            "those of b-1: its model contains b-1's, so a fit that comes to rest leaves no more",
        ),
    ),
)


@dataclass(frozen=True)
class CaseRun:
    """A case, calibrated."""

    case: Case
    result: CalibrationResult
    parameters: tuple[ParameterRow, ...]
    stiffness: tuple[StiffnessRow, ...]

    @property
    def ours(self) -> Figures:
        """Errors after calibration."""
        return Figures.of(self.result.residuals["calibrated"])


@cache
def tables() -> dict[str, Cells]:
    """The paper's tables: "nominal", "real" and one for each case."""
    return read_tables("stiffness_analysis_tables.csv")


def identified_names() -> tuple[str, ...]:
    """The parameters in which the real robot differs from the nominal one."""
    return differing(tables()["nominal"], tables()["real"])


def nominal_robot() -> Robot:
    """Table 2, with masses."""
    return table_robot("nominal", si_values(tables()["nominal"]), LINKS, PAYLOAD)


def actual_robot(data: str) -> Robot:
    """Table 1, with masses and the compliance of the joints that give way for a set of measurements."""
    robot = table_robot(f"real {data}", si_values(tables()["real"]), LINKS, PAYLOAD)
    springs = {f"{joint}.theta": Compliance("linear", (1.0 / STIFFNESS[joint],)) for joint in DEFLECTING[data]}
    return replace(robot, elastic=springs)


def poses() -> Array:
    """Joint positions (20, 6) [rad]."""
    return np.loadtxt(HERE / "stiffness_analysis_poses.csv", delimiter=",", skiprows=1)


def measured(data: str) -> Measurements:
    """What an instrument shows of the actual robot."""
    return simulate(actual_robot(data), poses(), rounding=ROUNDING)


def run_case(case: Case, non_negative: bool = False) -> CaseRun:
    """Simulate the measurements of a case and calibrate from Table 2.

    Args:
        case: one of CASES.
        non_negative: keep compliances from going below zero.
    """
    result = calibrate(
        nominal_robot(),
        measured(case.data),
        identify=identified_names(),
        elastic=dict.fromkeys(case.elastic, "linear"),
        non_negative=non_negative,
    )
    return CaseRun(case, result, _parameter_rows(case, result), _stiffness_rows(case, result))


def _parameter_rows(case: Case, result: CalibrationResult) -> tuple[ParameterRow, ...]:
    nominal, real, printed = tables()["nominal"], tables()["real"], tables()[case.name]
    found = {parameter.name: parameter for parameter in result.parameters}
    return tuple(
        ParameterRow(
            name=name,
            unit=printed[name].unit,
            nominal=nominal[name].value,
            actual=real[name].value,
            paper=printed[name].value,
            ours=found[name].identified,
            std=found[name].std,
            verdict=found[name].verdict,
        )
        for name in identified_names()
    )


def _stiffness_rows(case: Case, result: CalibrationResult) -> tuple[StiffnessRow, ...]:
    found = {element.element: element for element in result.elastic}
    rows = []
    for joint in case.elastic:
        element = found[f"{joint}.theta"]
        rows.append(
            StiffnessRow(
                joint=joint,
                actual=STIFFNESS[joint] if joint in case.deflecting else None,
                paper=PRINTED_STIFFNESS.get(case.name, {}).get(joint),
                compliance=element.coefficients[0],
                std=element.std[0],
                verdict=element.verdict,
            )
        )
    return tuple(rows)
