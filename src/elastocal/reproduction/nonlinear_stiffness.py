"""The paper on nonlinear joint stiffness: an HA006 whose joints 2 and 3 stiffen under load, calibrated law by law."""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.identification import CalibrationResult, GeneticSearch, calibrate
from elastocal.reproduction.ha006 import Experiment, identified_names, printed_table
from elastocal.reproduction.values import Figures, ParameterRow
from elastocal.validation import validate

BEFORE = Figures(3.52e-3, 8.22e-3)
"""The paper's errors of the nominal robot, 45 poses."""

CALIBRATED = Figures(1.15e-4, 2.4e-4)
"""The paper's after calibration, 45 poses."""

EVALUATED = Figures(1.67e-4, 6.05e-4)
"""The paper's after calibration, 95 poses."""


@dataclass(frozen=True)
class Rung:
    """A model of the joints.

    Attributes:
        name: for options.
        law: of joints 2 and 3; None: rigid.
        transition: how transition torques are searched for, "exact" or "ga".
        printed: whether it is the paper's.
    """

    name: str
    law: str | None = None
    transition: str = "exact"
    printed: bool = False

    @property
    def laws(self) -> dict[str, str]:
        """By joint, as `calibrate` takes them."""
        return {} if self.law is None else {"2": self.law, "3": self.law}


RUNGS = (
    Rung("rigid"),
    Rung("linear", "linear"),
    Rung("step-ga", "step", "ga", printed=True),
    Rung("step-exact", "step", printed=True),
    Rung("hinge", "hinge"),
)


GENETIC = GeneticSearch(population=30, generations=20)


@dataclass(frozen=True)
class RungRun:
    """A rung, calibrated on 45 poses and evaluated on 95."""

    rung: Rung
    result: CalibrationResult
    calibrated: Figures
    evaluated: Figures


@dataclass(frozen=True)
class Ladder:
    """The rungs on one simulated HA006.

    Attributes:
        experiment: robots and measurements.
        before: errors of the nominal robot on the 45 poses, and `before_evaluated` on the 95.
        runs: one for each rung asked for.
    """

    experiment: Experiment
    before: Figures
    before_evaluated: Figures
    runs: tuple[RungRun, ...]


def run_ladder(
    experiment: Experiment,
    rungs: tuple[Rung, ...] = RUNGS,
    *,
    non_negative: bool = False,
    genetic: GeneticSearch = GENETIC,
    seed: int = 0,
) -> Ladder:
    """Calibrate the nominal HA006 on the 45 poses with each model, and evaluate it on the 95.

    Args:
        experiment: what was measured.
        rungs: some of RUNGS.
        non_negative: keep compliances from going below zero.
        genetic: settings of the genetic algorithm.
        seed: of the genetic algorithm.
    """
    runs = []
    for rung in rungs:
        result = calibrate(
            experiment.nominal,
            experiment.calibration,
            identify=identified_names(),
            elastic=rung.laws,
            transition=genetic if rung.transition == "ga" else rung.transition,
            non_negative=non_negative,
            seed=seed,
        )
        calibrated = Figures.of(result.residuals["calibrated"])
        evaluated = Figures.of(validate(result.robot, experiment.evaluation).statistics)
        runs.append(RungRun(rung, result, calibrated, evaluated))
    before, before_evaluated = (
        Figures.of(validate(experiment.nominal, data).statistics)
        for data in (experiment.calibration, experiment.evaluation)
    )
    return Ladder(experiment, before, before_evaluated, tuple(runs))


def parameter_rows(experiment: Experiment, run: RungRun) -> tuple[ParameterRow, ...]:
    """The identified geometry beside the simulated robot's."""
    printed, found = printed_table(), {parameter.name: parameter for parameter in run.result.parameters}
    actual = experiment.actual_values
    return tuple(
        ParameterRow(
            name=name,
            unit=printed[name].unit,
            nominal=found[name].nominal or 0.0,
            actual=actual[name],
            paper=None,
            ours=found[name].identified,
            std=found[name].std,
            verdict=found[name].verdict,
        )
        for name in identified_names()
    )
