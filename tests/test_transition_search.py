"""The search for transition torques: nothing better is to be found, and what was there is found again."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.errors import InputError
from elastocal.identification import CalibrationResult, calibrate
from elastocal.identification.sums import misfit_of, normal_sums
from elastocal.identification.transition.grid import grids_of
from elastocal.identification.transition.search import search_exactly
from elastocal.identification.transition.trial import Problem, Trial, fit_at, polished
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Robot
from support.calibrations import measured
from support.robots import arm
from support.transitions import SPRINGS, actual_arm, one_blas_thread, problem

__all__ = ["one_blas_thread"]

SMALL = [
    ({"2": "step"}, 0, 3e-5),
    ({"3": "step"}, 1, 2e-4),
    ({"2": "hinge"}, 2, 3e-5),
    ({"2": "step", "3": "step"}, 3, 3e-5),
    ({"2": "hinge", "3": "hinge"}, 4, 3e-5),
    ({"2": "hinge", "3": "step"}, 5, 2e-4),
]


def small_problem(laws: dict[str, str], seed: int, noise: float) -> Problem:
    """Sixteen poses: so few that all combinations can be fitted."""
    return problem(arm(), measured(actual_arm(arm(), laws, seed), 16, seed, noise=noise), laws)


@pytest.mark.parametrize(("laws", "seed", "noise"), SMALL)
def test_fitting_all_combinations_finds_none_that_is_better(laws: dict[str, str], seed: int, noise: float):
    posed = small_problem(laws, seed, noise)
    best, search = search_exactly(posed)
    every = product(*(grid.torques.tolist() for grid in posed.grids.values()))
    misfits = [fit_at(posed, dict(zip(posed.grids, torques, strict=True))).misfit for torques in every]
    assert best.misfit <= min(misfits) * 1.001
    assert search.proven
    assert search.fits < max(len(misfits), 9)
    assert min(misfits) < 0.9 * posed.misfit  # there is something to be found


def test_the_sides_of_a_fit_are_those_of_the_fitted_robot():
    """Also where loads change places across the transition torque, as from the nominal to the fitted robot."""
    data = measured(actual_arm(arm(), {"3": "step"}), 150, 0, noise=3e-5)
    posed = problem(arm(), data, {"3": "step"})
    loads = posed.model(posed.torques).undeflected_loads(np.zeros(len(posed.names)))
    posed = replace(posed, start=np.zeros(len(posed.names)), loads=loads, grids=grids_of(loads, posed.laws))
    changed = 0
    for torque in posed.grids["3.theta"].torques[::6].tolist():
        trial = fit_at(posed, {"3.theta": torque})
        own = replace(trial.model, sides={})
        sums = [normal_sums(model, trial.solution.displacements, posed.variances) for model in (trial.model, own)]
        assert [misfit_of(found) for found in sums] == pytest.approx([trial.misfit] * 2, rel=1e-9)
        before, after = np.abs(posed.loads["3.theta"]) >= torque, sides_of(trial)["3.theta"]
        assert before.sum() == after.sum()
        changed += (before != after).any()
    assert changed > 3


def sides_of(trial: Trial) -> dict[str, np.ndarray]:
    """Which rows are above each transition torque, by element."""
    return {e: np.abs(loads) >= trial.torques[e] for e, loads in trial.loads.items()}


def test_a_hinge_between_the_loads_is_not_better_anywhere():
    posed = small_problem({"2": "hinge"}, 2, 3e-5)
    torques = posed.grids["2.theta"].torques
    fine = np.linspace(torques[0], torques[-1], 80)
    misfits = [fit_at(posed, {"2.theta": float(torque)}).misfit for torque in fine]
    assert search_exactly(posed)[0].misfit <= min(misfits) * 1.001


def test_three_elements_are_searched_without_a_proof():
    laws = {"2": "step", "3": "hinge", "5": "step"}
    data = measured(actual_arm(arm(), laws), 50, 0, noise=3e-5)
    assert not search_exactly(problem(arm(), data, laws))[1].proven
    result = calibrate(arm(), data, elastic=laws)
    assert any("not all combinations were compared" in note for note in result.notes)
    assert result.status == "converged"


NOISE_FREE = [
    ({"2": "step"}, ("position",), 0),
    ({"2": "step", "3": "step"}, ("position", "orientation"), 1),
    ({"3": "step", "2": "step", "5": "step"}, ("distance",), 2),
    ({"2": "hinge"}, ("distance",), 2),
    ({"2": "hinge", "3": "hinge"}, ("position",), 1),
    ({"5": "hinge", "2": "hinge", "3": "hinge"}, ("position", "orientation"), 0),
    ({"2": "step", "3": "hinge"}, ("position",), 3),
]


def sides(robot: Robot, data: Measurements) -> dict[str, np.ndarray]:
    """Which rows are above each transition torque, by element."""
    loads = Model(robot, (), data).undeflected_loads(np.zeros(0))
    return {e: np.abs(loads[e]) >= (found.transition_torque or 0.0) for e, found in robot.elastic.items()}


@pytest.mark.parametrize(("laws", "kinds", "seed"), NOISE_FREE)
def test_noise_free_data_give_back_transition_torques_and_coefficients(laws, kinds, seed):
    actual = actual_arm(arm(), laws, seed, kinds)
    data = measured(actual, 80, seed, kinds=kinds)
    result = calibrate(arm(), data, elastic=laws)
    assert result.status == "converged"
    found, true = sides(result.robot, data), sides(actual, data)
    for element in result.elastic:
        expected = actual.elastic[element.element]
        exactly = 1e-8 if set(laws.values()) == {"step"} else 2e-5
        assert element.coefficients == pytest.approx(expected.coefficients, rel=exactly)
        low, high = element.transition.gap
        assert low < expected.transition_torque < high
        np.testing.assert_array_equal(found[element.element], true[element.element])
        if element.law == "hinge":
            assert element.transition_torque == pytest.approx(expected.transition_torque, rel=2e-5)
        else:
            assert element.transition_torque == pytest.approx(0.5 * (low + high), rel=1e-9)


def torques_of(result: CalibrationResult) -> dict[str, float | None]:
    return {element.element: element.transition_torque for element in result.elastic}


@pytest.mark.parametrize("law", ["step", "hinge"])
def test_given_torques_are_kept_to_the_digit_and_go_with_the_elements_in_the_order_asked_for(law: str):
    laws = {"3": law, "2": law}
    data = measured(actual_arm(arm(), laws), 50, 0, noise=3e-5)
    result = calibrate(arm(), data, elastic=laws, transition=[75.123456789, 301.23456789])
    assert torques_of(result) == {"2.theta": 301.23456789, "3.theta": 75.123456789}
    assert result.search.method == "given"
    assert {p.verdict for p in result.parameters if p.name.endswith("transition_torque")} == {"fixed"}
    assert [element.transition_std for element in result.elastic] == [None, None]
    chosen = sides(result.robot, data)
    for element in result.elastic:
        sizes = np.abs(Model(result.robot, (), data).undeflected_loads(np.zeros(0))[element.element])
        np.testing.assert_array_equal(chosen[element.element], sizes >= element.transition_torque)


def test_true_torques_when_given_fit_noise_free_data():
    laws = {"2": "step", "3": "hinge"}
    actual = actual_arm(arm(), laws)
    given = [SPRINGS["2"][1], SPRINGS["3"][1]]
    result = calibrate(arm(), measured(actual, 60, 0), elastic=laws, transition=given)
    assert result.residuals["calibrated"].max < 1e-12
    for element in result.elastic:
        assert element.coefficients == pytest.approx(actual.elastic[element.element].coefficients, rel=1e-8)


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ([222.0], "expected one torque for each element with a transition (2.theta, 3.theta), found 1"),
        ([222.0, 80.0, 9.0], "expected one torque for each element with a transition (2.theta, 3.theta), found 3"),
        ([222.0, -80.0], "expected a positive torque, found -80"),
        ([222.0, float("nan")], "expected a positive torque, found nan"),
        ("exactly", "no method 'exactly'; did you mean 'exact'?"),
    ],
)
def test_torques_and_methods_that_make_no_sense_are_told(given, fault: str):
    data = measured(actual_arm(arm(), {}), 20, 0)
    with pytest.raises(InputError) as error:
        calibrate(arm(), data, elastic={"2": "step", "3": "hinge", "5": "linear"}, transition=given)
    assert fault in str(error.value)


MIXED = {"2": "step", "3": "hinge", "5": "linear"}


def same(one: CalibrationResult, other: CalibrationResult) -> None:
    """The same torques and links."""
    for mine, theirs in zip(one.elastic, other.elastic, strict=True):
        tolerance = 1e-9 if mine.law == "step" else 1e-6
        assert (mine.transition_torque or 0.0) == pytest.approx(theirs.transition_torque or 0.0, rel=tolerance)
        assert mine.coefficients == pytest.approx(theirs.coefficients, rel=1e-6)
    theirs = {p.name: p for p in other.parameters}
    for p in one.parameters:
        if not p.name.startswith("base"):
            assert p.identified == pytest.approx(theirs[p.name].identified, rel=1e-6, abs=1e-9)


def noisy() -> tuple[Robot, Measurements]:
    actual = actual_arm(arm(), {"2": "step", "3": "hinge"})
    return actual, measured(actual, 50, 0, noise=5e-5, kinds=("position", "orientation"), noise_angle=1e-4)


def test_the_order_of_poses_changes_nothing():
    _, data = noisy()
    shuffled = data.take(np.random.default_rng(3).permutation(len(data)))
    same(calibrate(arm(), data, elastic=MIXED), calibrate(arm(), shuffled, elastic=MIXED))


def test_moving_the_instrument_changes_no_transition_torque_and_no_link():
    _, data = noisy()
    turn = Rotation.from_rotvec([0.4, -1.0, 2.0])
    moved = replace(
        data,
        position=np.add(turn.apply(data.position), [3.0, -1.0, 0.5]),
        orientation=turn.as_matrix() @ data.orientation,
    )
    same(calibrate(arm(), data, elastic=MIXED), calibrate(arm(), moved, elastic=MIXED))


def test_turning_all_loads_round_changes_no_transition_torque():
    """A controller that counts joint 2 the other way sees the same robot."""
    _, data = noisy()
    rows = list(arm().rows)
    rows[1] = replace(rows[1], sign=-1)
    counted = replace(data, q=data.q * [1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
    same(calibrate(arm(), data, elastic=MIXED), calibrate(replace(arm(), rows=tuple(rows)), counted, elastic=MIXED))


def test_the_fit_of_a_hinge_does_not_jump_where_its_torque_passes_a_load():
    posed = small_problem({"2": "hinge"}, 2, 3e-5)
    for load in np.sort(np.abs(posed.loads["2.theta"]))[3:-3]:
        below, on, above = (fit_at(posed, {"2.theta": float(load * (1.0 + d))}).misfit for d in (-1e-7, 0.0, 1e-7))
        assert below == pytest.approx(on, rel=1e-4)
        assert above == pytest.approx(on, rel=1e-4)


@pytest.mark.parametrize("seed", [0, 2])
def test_freeing_the_torques_of_hinges_makes_no_fit_worse_and_some_better(seed: int):
    posed = small_problem({"2": "hinge", "3": "step"}, seed, 3e-5)
    steps = posed.grids["3.theta"].torques[[2, 7]]
    better = 0
    for torques in product(posed.grids["2.theta"].torques.tolist(), steps.tolist()):
        trial = fit_at(posed, dict(zip(("2.theta", "3.theta"), torques, strict=True)))
        found = polished(posed, trial)
        assert found.misfit <= trial.misfit
        assert found.torques["3.theta"] == pytest.approx(trial.torques["3.theta"], rel=1e-3)
        better += found.misfit < 0.99 * trial.misfit
    assert better > 2


def test_a_hinge_whose_torque_is_a_measured_load_is_found():
    """The misfit is lowest at a kink: the search must come to it from both sides."""
    actual = actual_arm(arm(), {"2": "hinge"})
    data = measured(actual, 80, 0)
    sizes = np.sort(np.abs(Model(actual, (), data).undeflected_loads(np.zeros(0))["2.theta"]))
    for load in sizes[[25, 40, 55]]:
        kinked = replace(actual.elastic["2.theta"], transition_torque=float(load))
        robot = replace(actual, elastic={"2.theta": kinked})
        result = calibrate(arm(), measured(robot, 80, 0), elastic={"2": "hinge"})
        assert result.elastic[0].transition_torque == pytest.approx(load, rel=1e-4)
        assert result.elastic[0].coefficients == pytest.approx(kinked.coefficients, rel=1e-4)
