"""Several targets, payloads, stations, probe mountings, files and kinds of observation in one fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate
from elastocal.measurements import Measurements, concatenate
from elastocal.parameters import parameters_of
from elastocal.robot import Compliance, Frame, Payload, Robot
from elastocal.simulation import random_poses, simulate
from elastocal.validation import validate
from support.robots import arm, placed

ELASTIC = {"2": "linear", "3": "linear"}


def drawn(seed: int, elastic: bool = False) -> Robot:
    """An actual arm, off by 1 mm and 1 mrad, seen from anywhere."""
    rng = np.random.default_rng(seed)
    robot = arm(elastic=elastic)
    kept = {name: c for name, c in robot.elastic.items() if name in ("2.theta", "3.theta")}
    deltas = {e.name: 1e-3 * rng.standard_normal() for row in robot.row_elements for e in row}
    return placed(replace(robot.displaced(deltas), elastic=kept), rng)


def measure(actual: Robot, count: int, seed: int, **options: object) -> Measurements:
    return simulate(actual, random_poses(actual, count, seed), noise=1e-5, noise_angle=1e-5, seed=seed, **options)


def value(result, name: str) -> float:
    return next(p.identified for p in result.parameters if p.name == name)


def test_known_targets_on_an_unknown_tool_tell_how_the_tool_is_turned():
    points = {"a": (0.1, 0.0, 0.0), "b": (0.0, 0.1, 0.02), "c": (-0.08, 0.0, 0.05)}
    actual = replace(drawn(0), targets={name: Frame(xyz, known=True) for name, xyz in points.items()})
    nominal = replace(arm(), targets=actual.targets)
    data = concatenate([measure(actual, 30, i, target=name) for i, name in enumerate(points)])
    result = calibrate(nominal, data)
    assert result.status == "converged"
    assert len(result.gauge.kept) == 30
    assert result.residuals["calibrated"].mean < 3e-5


def test_unknown_targets_are_found_one_by_one_and_the_tool_stays():
    actual = drawn(1)
    targets = {"a": Frame((0.1, 0.0, 0.0), known=True), "b": Frame((0.0, 0.1, 0.02), known=True)}
    actual = replace(actual, targets=targets)
    nominal = replace(arm(), targets={"a": Frame(), "b": Frame()})
    data = concatenate([measure(actual, 40, i, target=name) for i, name in enumerate(targets)])
    result = calibrate(nominal, data)
    assert result.residuals["calibrated"].mean < 3e-5
    assert result.gauge.dropped["tool.tx"].verdict == "dependent"
    apart = result.robot.targets["a"].translation - result.robot.targets["b"].translation
    assert np.linalg.norm(apart) == pytest.approx(np.hypot(np.hypot(0.1, 0.1), 0.02), abs=2e-3)


def test_probe_mountings_are_targets_with_an_orientation():
    mountings = {
        "first": Frame((0.1, 0.0, 0.0), (0.1, 0.2, -0.4), known=True),
        "second": Frame((0.0, 0.1, 0.02), (2.0, -0.3, 1.0), known=True),
    }
    actual = replace(drawn(2), targets=mountings)
    nominal = replace(arm(), targets={"first": Frame(), "second": Frame()})
    kinds = ("position", "orientation")
    data = concatenate([measure(actual, 40, i, target=name, kinds=kinds) for i, name in enumerate(mountings)])
    result = calibrate(nominal, data)
    assert result.status == "converged"
    assert len(result.gauge.kept) == 36
    assert result.residuals["calibrated"].mean < 2e-5
    assert result.residuals["calibrated"].angle.mean < 3e-5


def test_stations_have_one_base_each():
    actual = drawn(3)
    rng = np.random.default_rng(3)
    stations = {
        name: Frame(tuple(rng.uniform(-3, 3, 3)), tuple(rng.uniform(-3, 3, 3)), known=True)
        for name in ("north", "south")
    }
    actual = replace(actual, stations=stations)
    nominal = replace(arm(), stations={"north": Frame(), "south": Frame()})
    data = concatenate([measure(actual, 40, i, station=name) for i, name in enumerate(stations)])
    result = calibrate(nominal, data)
    assert result.status == "converged"
    assert len(result.gauge.kept) == 27 + 6
    assert result.residuals["calibrated"].mean < 2.5e-5
    assert not any(name.startswith("base") for name in result.gauge.kept)
    assert result.robot.stations["north"].known
    assert result.robot.stations["south"].known


def test_payloads_tell_compliance_from_the_same_poses():
    loads = {"light": Payload(2.0, (0.0, 0.0, 0.05)), "heavy": Payload(30.0, (0.0, 0.02, 0.15))}
    actual = replace(drawn(4, elastic=True), loads=loads)
    data = concatenate([measure(actual, 30, 0, load="light"), measure(actual, 30, 0, load="heavy")])
    with_loads = calibrate(replace(arm(), loads=loads), data, elastic=ELASTIC)
    without = calibrate(arm(), measure(replace(actual, loads={}), 60, 0), elastic=ELASTIC)
    assert with_loads.status == "converged"
    assert with_loads.residuals["calibrated"].mean < 2e-5
    assert with_loads.elastic[0].coefficients[0] == pytest.approx(2e-6, abs=5 * with_loads.elastic[0].std[0])
    assert with_loads.elastic[0].std[0] < without.elastic[0].std[0]


def test_an_external_wrench_loads_joints_whose_axis_is_vertical():
    rng = np.random.default_rng(5)
    wrench = np.concatenate([rng.uniform(-200, 200, (60, 3)), np.zeros((60, 3))], axis=1)
    actual = arm(elastic=True)
    actual = placed(replace(actual, elastic={"1.theta": actual.elastic["1.theta"]}), rng)
    data = measure(actual, 60, 5, wrench=wrench)
    result = calibrate(arm(), data, elastic={"1": "linear"})
    assert result.elastic[0].verdict == "identified"
    assert result.elastic[0].coefficients[0] == pytest.approx(1e-6, abs=5 * result.elastic[0].std[0])


def test_positions_orientations_and_distances_are_fitted_together():
    actual = drawn(6)
    parts = [
        measure(actual, 30, 0, kinds=("position",)),
        measure(actual, 30, 1, kinds=("position", "orientation")),
        measure(actual, 30, 2, kinds=("distance",)),
        measure(actual, 30, 3, kinds=("orientation",)),
    ]
    result = calibrate(arm(), concatenate(parts))
    assert result.status == "converged"
    assert len(result.gauge.kept) == 30
    assert set(result.model_sigma) == {"position", "orientation", "distance"}
    for sigma in result.model_sigma.values():
        assert sigma == pytest.approx(1e-5, rel=0.4)


def test_compliance_of_an_element_that_is_no_joint_is_identified():
    actual = drawn(7)
    actual = replace(actual, elastic={"3.alpha": Compliance("linear", (3e-6,))})
    loaded = replace(actual, tool_load=Payload(20.0, (0.1, 0.05, 0.2)))
    nominal = replace(arm(), tool_load=loaded.tool_load)
    result = calibrate(nominal, measure(loaded, 120, 7), elastic={"3.alpha": "linear"})
    assert result.elastic[0].element == "3.alpha"
    assert result.elastic[0].coefficients[0] == pytest.approx(3e-6, abs=5 * result.elastic[0].std[0])
    assert result.elastic[0].verdict == "identified"


def test_known_compliance_is_used_and_not_identified():
    actual = drawn(8, elastic=True)
    nominal = replace(arm(), elastic=actual.elastic)
    result = calibrate(nominal, measure(actual, 60, 8))
    assert result.residuals["calibrated"].mean < 2e-5
    assert {element.verdict for element in result.elastic} == {"fixed"}


def test_identify_and_fix_choose_by_pattern():
    data = measure(drawn(9), 60, 9)
    offsets = calibrate(arm(), data, identify=["*.theta"])
    assert {name for name in offsets.gauge.kept if name[0].isdigit()} == {f"{i}.theta" for i in range(2, 6)}
    fixed = calibrate(arm(), data, fix=["5.*", "*.alpha"])
    assert not any(name.startswith("5.") or name.endswith("alpha") for name in fixed.gauge.kept)
    assert next(p for p in fixed.parameters if p.name == "5.a").verdict == "fixed"


def test_refit_base_finds_an_instrument_that_was_moved():
    actual = drawn(10)
    robot = calibrate(arm(), measure(actual, 60, 10)).robot
    moved = replace(actual, base=Frame((1.0, -2.0, 0.3), (0.4, 1.0, -2.0), known=True))
    later = measure(moved, 40, 11)
    assert validate(robot, later).statistics.mean > 0.1
    again = validate(robot, later, refit=["base"])
    assert again.statistics.mean < 3e-5
    assert len(again.fitted_frames) == 6
    assert any("base fitted to these data" in warning for warning in again.warnings)
    assert parameters_of(again.robot)["2.alpha"] == parameters_of(robot)["2.alpha"]
