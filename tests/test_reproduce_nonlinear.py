"""The paper on nonlinear joint stiffness, run anew on a simulated HA006: the ladder from rigid to hinge."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.elasticity import HARMONIC_DRIVE, Load
from elastocal.identification import GeneticSearch
from elastocal.prediction import Model
from elastocal.reproduction import RUNGS, Ladder, RungRun, ha006
from elastocal.reproduction.nonlinear_stiffness import run_ladder

FEW = GeneticSearch(population=12, generations=8)
"""Enough for a test."""


@pytest.fixture(scope="module")
def ladder() -> Ladder:
    """All rungs as the command has them, the genetic algorithm small."""
    return run_ladder(ha006.experiment(), genetic=FEW)


@pytest.fixture(scope="module")
def rungs(ladder: Ladder) -> dict[str, RungRun]:
    """The rungs by name."""
    return {run.rung.name: run for run in ladder.runs}


def rms(run: RungRun) -> float:
    """Root mean square of the errors on the fitted poses [m]."""
    return run.result.residuals["calibrated"].rms


def test_the_ladder_has_five_rungs(rungs: dict[str, RungRun]):
    assert list(rungs) == ["rigid", "linear", "step-ga", "step-exact", "hinge"]
    assert all(run.result.status == "converged" for run in rungs.values())


def test_before_calibration_the_error_is_the_papers(ladder: Ladder):
    assert 3e-3 <= ladder.before.mean <= 5e-3


@pytest.mark.parametrize("name", ["step-ga", "step-exact"])
def test_the_step_law_reaches_the_papers_errors(rungs: dict[str, RungRun], name: str):
    assert rungs[name].calibrated.mean <= 1.2e-4
    assert rungs[name].evaluated.mean <= 1.7e-4
    assert rungs[name].evaluated.max <= 6.05e-4


def test_every_rung_is_better_than_the_one_below_on_poses_it_has_not_seen(rungs: dict[str, RungRun]):
    errors = [rungs[name].evaluated.mean for name in ("rigid", "linear", "step-exact", "hinge")]
    assert errors == sorted(errors, reverse=True)


def test_no_search_beats_the_exact_one(rungs: dict[str, RungRun]):
    exact, genetic, linear = (rms(rungs[name]) for name in ("step-exact", "step-ga", "linear"))
    assert exact * (1.0 - 1e-9) <= genetic < linear


def test_enough_generations_find_what_the_exact_search_finds(rungs: dict[str, RungRun]):
    (run,) = run_ladder(ha006.experiment(), (RUNGS[2],), genetic=GeneticSearch(20, 12)).runs
    assert rms(run) == pytest.approx(rms(rungs["step-exact"]), rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_another_seed_is_another_robot_with_the_same_outcome(ladder: Ladder, seed: int):
    few = tuple(rung for rung in RUNGS if rung.name in ("linear", "step-exact", "hinge"))
    other = run_ladder(ha006.experiment(seed), few)
    linear, step, hinge = other.runs
    assert other.before != ladder.before
    assert step.calibrated.mean <= 1.2e-4 < linear.calibrated.mean
    assert hinge.evaluated.mean < step.evaluated.mean <= 1.7e-4


def test_the_same_seed_gives_the_same_to_the_last_digit(ladder: Ladder):
    again = run_ladder(ha006.experiment(), genetic=FEW)
    assert (again.before, again.before_evaluated) == (ladder.before, ladder.before_evaluated)
    for one, other in zip(again.runs, ladder.runs, strict=True):
        assert (one.calibrated, one.evaluated) == (other.calibrated, other.evaluated)


def test_non_negative_compliances_stay_so():
    found = run_ladder(ha006.experiment(), (RUNGS[3],), non_negative=True).runs[0].result
    assert min(c for element in found.elastic for c in element.coefficients) >= 0.0


def test_evaluation_poses_include_those_of_calibration():
    drawn = ha006.experiment()
    assert (len(drawn.calibration), len(drawn.evaluation)) == (45, 95)
    assert np.array_equal(drawn.calibration.q, drawn.evaluation.q[:45])


def test_the_joints_stiffen_as_is_said():
    """Local stiffness over the loads that occur: 0.8e5 to 2.2e5 N m/rad in joint 2, 0.5e5 to 1.5e5 in joint 3."""
    drawn = ha006.experiment()
    loads = Model(drawn.actual, (), drawn.evaluation).undeflected_loads(np.zeros(0))
    for joint, low, high in (("2", 0.8e5, 2.2e5), ("3", 0.5e5, 1.5e5)):
        load = loads[f"{joint}.theta"]
        stiffness = 1.0 / HARMONIC_DRIVE.respond(ha006.DRIVES[joint], Load(load, load, 0.0)).compliance
        assert stiffness.min() == pytest.approx(low, rel=0.1)
        assert stiffness.max() == pytest.approx(high, rel=0.1)


def test_the_identified_set_is_the_printed_one():
    names = ha006.identified_names()
    assert len(names) == 26
    assert not {"2.d", "6.d", "6.theta", "2.beta", "6.b", "T.alpha", "T.beta", "T.theta"} & set(names)
    assert {"1.beta", "1.b", "3.d", "6.alpha", "T.a", "T.b", "T.d"} <= set(names)


def test_two_of_the_printed_set_cannot_be_told_from_others(rungs: dict[str, RungRun]):
    dropped = rungs["rigid"].result.gauge.dropped
    assert {name: found.partners for name, found in dropped.items()} == {"6.alpha": ("5.d",), "6.a": ("5.theta",)}


def test_the_wrist_is_not_printed_as_it_is():
    assert ha006.printed_table()["6.alpha"].text == "0"
    assert ha006.nominal_robot().rows[5].geometry["alpha"] == pytest.approx(np.pi / 2.0)
