"""Confidence intervals of parameters, and groups of parameters that are told together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.identification import CalibrationResult
from elastocal.identification.intervals import correlated_groups, student
from elastocal.identification.transition.grid import Grid
from elastocal.identification.transition.likelihood import _interval
from elastocal.robot import Compliance
from support.calibrations import measured
from support.robots import arm, placed
from support.transitions import SPRINGS


@pytest.mark.parametrize(("freedom", "tabulated"), [(1, 12.706), (2, 4.303), (5, 2.571), (20, 2.086), (1e6, 1.960)])
def test_students_quantile_is_that_of_the_tables(freedom: float, tabulated: float):
    assert student(freedom) == pytest.approx(tabulated, abs=5e-4)


def test_parameters_that_hang_together_are_one_group():
    rng = np.random.default_rng(0)
    common = rng.standard_normal(2000)
    x = rng.standard_normal((5, 2000))
    x[1], x[3] = common + 0.1 * x[1], -common + 0.1 * x[3]
    assert correlated_groups("abcde", np.cov(x)) == (("b", "d"),)


def test_groups_are_chained_and_do_not_depend_on_units():
    correlation = np.array([[1.0, 0.97, 0.9], [0.97, 1.0, 0.97], [0.9, 0.97, 1.0]])
    for units in (np.ones(3), np.array([1e-6, 1.0, 1e3])):
        assert correlated_groups("abc", correlation * np.outer(units, units)) == (("a", "b", "c"),)
    assert correlated_groups("ab", np.diag([1.0, 0.0])) == ()


@pytest.fixture(scope="module")
def hinge() -> tuple[CalibrationResult, CalibrationResult]:
    """A robot with a hinge and one with a step, calibrated."""
    found = []
    for law in ("hinge", "step"):
        actual = placed(replace(arm(), elastic={"2.theta": Compliance(law, *SPRINGS["2"])}), np.random.default_rng(1))
        found.append(ec.calibrate(arm(), measured(actual, 60, 1, noise=2e-5), elastic={"2": law}))
    return found[0], found[1]


def test_intervals_reach_students_quantile_to_both_sides(hinge: tuple[CalibrationResult, CalibrationResult]):
    for result in hinge:
        reach = student(result.freedom)
        for p in result.parameters:
            assert (p.interval is None) == (p.std is None)
            if p.interval is not None and not p.name.endswith("transition_torque"):
                assert p.interval == pytest.approx((p.identified - reach * p.std, p.identified + reach * p.std))


def test_degrees_of_freedom_are_coordinates_less_parameters(hinge: tuple[CalibrationResult, CalibrationResult]):
    for result in hinge:
        assert result.freedom == pytest.approx(result.coordinates - len(result.names), abs=1e-6)


def test_the_interval_of_a_steps_torque_ends_at_loads_of_the_data(hinge: tuple[CalibrationResult, CalibrationResult]):
    step = hinge[1]
    low, high = next(p.interval for p in step.parameters if p.name == "2.theta.transition_torque")
    gap = step.elastic[0].transition.gap
    assert low <= gap[0] < step.elastic[0].transition_torque < gap[1] <= high
    assert low <= SPRINGS["2"][1] <= high


def test_the_interval_of_a_hinges_torque_is_where_the_misfit_of_fits_at_it_rises_by_so_much(
    hinge: tuple[CalibrationResult, CalibrationResult],
):
    result = hinge[0]
    interval = next(p.interval for p in result.parameters if p.name == "2.theta.transition_torque")
    data = result.errors.data

    def misfit(torque: float) -> float:
        fitted = ec.calibrate(arm(), data, elastic={"2": "hinge"}, transition=[torque])
        return float((fitted.errors.calibrated.position**2).sum())

    least = float((result.errors.calibrated.position**2).sum())
    for end in interval:
        rise = (misfit(end) - least) / (least / result.freedom)
        assert rise == pytest.approx(student(result.freedom) ** 2, rel=0.1)


def test_an_interval_without_end_in_the_data_goes_on():
    grid = Grid(np.arange(1.0, 9.0), np.array([3.5, 4.5, 5.5]), smooth=False, whole=True)
    assert _interval(grid, np.array([0.0, 9.0, 9.0]), 4.0) == (0.0, 4.0)
    assert _interval(grid, np.array([9.0, 1.0, 0.0]), 4.0) == (4.0, np.inf)
    smooth = replace(grid, smooth=True)
    assert _interval(smooth, np.array([8.0, 0.0, 8.0]), 4.0) == (4.0, 5.0)


def test_intervals_and_groups_are_in_the_saved_result(hinge: tuple[CalibrationResult, CalibrationResult], tmp_path):
    result = hinge[0]
    ec.save_result(result, tmp_path / "result")
    saved = ec.load_result(tmp_path / "result")
    assert saved.names == result.names
    np.testing.assert_array_equal(saved.covariance, result.covariance)
    assert [p.interval for p in saved.parameters] == [p.interval for p in result.parameters]
    assert saved.model_sigma == pytest.approx(result.model_sigma)
