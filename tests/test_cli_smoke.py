"""Every command on every kind of robot and of measurement: it ends well, and calibration helps."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.robot import Compliance, Frame, Payload, Robot, Row
from support.files import Desk, desk, flawed
from support.robots import arm
from support.urdf import robot_urdf

__all__ = ["desk"]

KINDS = {
    "position": ("position",),
    "pose": ("position", "orientation"),
    "distance": ("distance",),
}

SHAPES = ("turning", "on a track", "coupled")

COUPLING = tuple(tuple(float(i == j or (i, j) == (2, 1)) for j in range(6)) for i in range(6))
"""A parallelogram: the third joint of the model turns with the second."""


def in_convention(rows: tuple[Row, ...], convention: str) -> tuple[Row, ...]:
    """The rows of a modified DH table in another convention."""
    if convention == "modified-dh":
        return rows
    if convention == "standard-dh":
        # alpha and a of the next row belong to this one; those of the first are zero
        ahead = [row.geometry for row in rows[1:]] + [{"alpha": 0.0, "a": 0.0}]
        tables = [{**row.geometry, "alpha": g["alpha"], "a": g["a"]} for row, g in zip(rows, ahead, strict=True)]
        return tuple(replace(row, geometry=table) for row, table in zip(rows, tables, strict=True))
    origins = []
    for row in rows:
        alpha, a, d = row.geometry["alpha"], row.geometry["a"], row.geometry["d"]
        origins.append(Frame((a, -d * np.sin(alpha), d * np.cos(alpha)), (alpha, 0.0, 0.0)))
    return tuple(replace(row, geometry={}, origin=origin) for row, origin in zip(rows, origins, strict=True))


def nominal_robot(convention: str, shape: str) -> Robot:
    """An arm, in a convention; perhaps on a track, perhaps with a parallelogram."""
    robot = arm()
    rows = robot.rows
    if shape == "on a track":
        track = Row(
            "track", "prismatic", {"alpha": 0.0, "a": 0.0, "theta": 0.0, "d": 0.0}, limits=(-1.0, 1.0), mass=80.0
        )
        turned = {**rows[0].geometry, "alpha": 1.2}
        rows = (track, replace(rows[0], geometry=turned), *rows[1:])
    rows = in_convention(rows, convention)
    return replace(robot, convention=convention, rows=rows, coupling=COUPLING if shape == "coupled" else None)


def measured(desk: Desk, nominal: Robot, kind: str) -> Robot:
    """Write robot and measurements of what was built after it; with the first guess that distances alone need."""
    rng = np.random.default_rng(5)
    guess = {"base": Frame((2.5, -1.0, 0.4), (0.0, 0.0, 2.0)), "tool": Frame((0.05, 0.02, 0.1), (0.0, 0.0, 0.0))}
    placed = {
        "base": Frame((2.51, -1.02, 0.41), (0.01, -0.02, 2.01)),
        "tool": Frame((0.06, 0.02, 0.11), (0.1, 0.1, 0.1)),
    }
    actual = flawed(nominal, rng).with_frames({name: replace(frame, known=True) for name, frame in placed.items()})
    robot = nominal.with_frames(guess) if kind == "distance" else nominal
    ec.save_robot(robot, desk.folder / "robot.toml")
    q = ec.random_poses(actual, 90, 7)
    data = ec.simulate(actual, q, kinds=KINDS[kind], noise=1e-5, noise_angle=1e-5, seed=7)
    ec.save_measurements(data.take(np.arange(60)), nominal, desk.folder / "fit.csv")
    ec.save_measurements(data.take(np.arange(60, 90)), nominal, desk.folder / "held_out.csv")
    return actual


def flat(statistics: dict[str, object]) -> dict[str, object]:
    """Statistics with those of the angle beside them."""
    angle = statistics.get("angle", {})
    return {name: value for name, value in statistics.items() if name != "angle"} | {
        f"angle {name}": value for name, value in angle.items()
    }


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_calibration_helps_and_validation_confirms_it(desk: Desk, convention: str, shape: str, kind: str):
    measured(desk, nominal_robot(convention, shape), kind)
    result = json.loads(desk.done("calibrate robot.toml fit.csv --held-out held_out.csv -o result --json"))
    before, after = (result["residuals"][name] for name in ("held_out_nominal", "held_out"))
    assert after["mean"] < 0.2 * before["mean"]
    if kind == "pose":
        assert after["angle"]["mean"] < 0.2 * before["angle"]["mean"]
    found = json.loads(desk.done("validate result/robot.toml held_out.csv --json"))["residuals"]["held_out"]
    assert flat(found) == pytest.approx(flat(after), rel=1e-6)
    assert "held-out rows" in desk.done("calibrate robot.toml fit.csv --holdout 0.3")
    assert "all rows" in desk.done("validate robot.toml held_out.csv")


@pytest.mark.parametrize("kinds", ["position", "position,orientation"])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_what_is_simulated_is_calibrated(desk: Desk, convention: str, shape: str, kinds: str):
    ec.save_robot(nominal_robot(convention, shape), desk.folder / "robot.toml")
    drawn = f"--poses 80 --geometry-error 0.5mm,0.5mrad --kinds {kinds} --noise 0.02mm --floor 0m --cone 30deg"
    desk.done(f"simulate robot.toml {drawn} --write-actual actual.toml -o fit.csv")
    true = json.loads(desk.done("validate actual.toml fit.csv --json"))["residuals"]["held_out"]
    found = json.loads(desk.done("calibrate robot.toml fit.csv --holdout 0.3 --json"))["residuals"]
    assert true["mean"] < 5e-5
    assert found["held_out"]["mean"] < 0.2 * found["held_out_nominal"]["mean"]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_what_is_calibrated_is_exported_and_predicts_the_same(desk: Desk, convention: str, shape: str):
    measured(desk, nominal_robot(convention, shape), "pose")
    desk.done("calibrate robot.toml fit.csv -o result")
    desk.done("export result/robot.toml --to urdf -o out.urdf")
    one, other = (
        flat(json.loads(desk.done(f"validate {robot} held_out.csv --json"))["residuals"]["held_out"])
        for robot in ("result/robot.toml", "out.urdf")
    )
    assert one == pytest.approx(other, rel=1e-9)
    desk.done("export result/robot.toml --to corrections-csv -o corrections.csv")
    for to in ("dh-csv", "mdh-csv"):
        desk.done(f"export result/robot.toml --to {to} -o {to}", 2 if shape == "coupled" else 0)
    desk.done("export result/robot.toml --to ur-yaml -o out.yaml", 0 if shape == "turning" else 2)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_what_is_calibrated_is_compensated(desk: Desk, convention: str, shape: str):
    nominal = nominal_robot(convention, shape)
    measured(desk, nominal, "pose")
    desk.done("calibrate robot.toml fit.csv -o result")
    desk.run("compensate result/robot.toml held_out.csv --frame instrument -o corrected.csv")
    found = pl.read_csv(desk.folder / "corrected.csv").filter(pl.col("reached"))
    assert found.height > 20
    assert found["error_after [mm]"].max() < 1e-6
    assert found["error_before [mm]"].mean() > 0.1


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_compliance_is_found_in_every_convention(desk: Desk, convention: str):
    nominal = nominal_robot(convention, "turning")
    stiff = measured(desk, nominal, "position")
    actual = replace(
        stiff, elastic={"2.theta": Compliance("linear", (5e-6,)), "3.theta": Compliance("linear", (8e-6,))}
    )
    data = ec.simulate(actual, ec.random_poses(actual, 90, 7), noise=1e-5, seed=7)
    ec.save_measurements(data, nominal, desk.folder / "soft.csv")
    result = json.loads(desk.done("calibrate robot.toml soft.csv --elastic 2,3 --json"))
    found = [(element["coefficients"][0], element["std"][0]) for element in result["elastic"]]
    for (value, std), true in zip(found, (5e-6, 8e-6), strict=True):
        assert abs(value - true) < 5.0 * std < true


def test_a_urdf_is_calibrated_like_the_robot_it_describes(desk: Desk):
    nominal = nominal_robot("modified-dh", "turning")
    measured(desk, nominal, "position")
    (desk.folder / "robot.urdf").write_text(robot_urdf(nominal).replace('lower="-3" upper="3"', 'lower="-4" upper="4"'))
    command = "calibrate {} fit.csv --held-out held_out.csv --json"
    one, other = (
        json.loads(desk.done(command.format(robot)))["residuals"]["held_out"]
        for robot in ("robot.toml", "robot.urdf --tip tool")
    )
    assert one["n"] == other["n"] == 30
    assert other["mean"] == pytest.approx(one["mean"], rel=0.1)


def test_targets_stations_payloads_and_descriptors_go_together(desk: Desk):
    nominal = replace(
        arm(),
        targets={"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.1, 0.05)), "c": Frame()},
        stations={"north": Frame(), "south": Frame()},
        loads={"heavy": Payload(20.0, (0.0, 0.0, 0.1))},
        base=Frame(known=True),
    )
    rng = np.random.default_rng(3)
    elsewhere = Frame((2.0, 1.0, 0.0), (0.0, 0.1, 1.0), known=True)
    actual = replace(flawed(nominal, rng), tool=Frame((0.0, 0.0, 0.1), known=True))
    actual = replace(actual, stations={"north": elsewhere, "south": replace(elsewhere, xyz=(-2.0, 0.0, 0.3))})
    ec.save_robot(nominal, desk.folder / "robot.toml")
    for i, (target, station, load) in enumerate([("a", "north", None), ("b", "south", "heavy"), ("c", "north", None)]):
        q = ec.random_poses(actual, 40, i)
        data = ec.simulate(actual, q, noise=1e-5, seed=i, target=target, station=station, load=load)
        ec.save_measurements(data, nominal, desk.folder / f"{target}.csv")
    pl.read_csv(desk.folder / "a.csv").write_parquet(desk.folder / "a.parquet")
    (desk.folder / "b.toml").write_text(
        'format = "elastocal-measurements/1"\nfile = "b.csv"\n[columns]\n'
        'q = { columns = ["q1 [deg]", "q2 [deg]", "q3 [deg]", "q4 [deg]", "q5 [deg]", "q6 [deg]"], unit = "deg" }\n'
        'position = { columns = ["x [mm]", "y [mm]", "z [mm]"], unit = "mm" }\n'
        'target = { value = "b" }\nstation = { value = "south" }\nload = { value = "heavy" }\n'
    )
    files = "a.parquet b.toml c.csv"
    result = json.loads(desk.done(f"calibrate robot.toml {files} --holdout 0.3 -o result --json"))
    assert result["residuals"]["held_out"]["mean"] < 0.1 * result["residuals"]["held_out_nominal"]["mean"]
    found = json.loads(desk.done(f"validate result/robot.toml {files} --json"))
    assert found["parts"].keys() >= {"a.parquet", "b.toml", "station north", "target b", "load heavy", "load none"}
    assert all(part["mean"] < 1e-4 for part in found["parts"].values())
