"""The command `plan`: its table, filled in, is what `calibrate` takes; and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.robot import Compliance, Frame, Payload
from support.files import ROBOT, Desk, contents, desk
from support.robots import arm

__all__ = ["desk"]

QUICK = "plan robot.toml --pool 100"

TOOL = Frame((0.1, -0.05, 0.15))


def save_arm(desk: Desk, **changes: object) -> None:
    ec.save_robot(replace(arm(), **changes), desk.folder / "robot.toml")


@pytest.mark.parametrize("kinds", ["position", "position,orientation", "distance"])
def test_a_plan_is_filled_in_and_calibrated(desk: Desk, kinds: str):
    """As planned on paper: every measured value goes into the empty column of its header."""
    base = Frame((2.5, -1.0, 0.4), (0.0, 0.0, 2.0))
    targets = {"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.15, 0.05))}
    loads = {"heavy": Payload(30.0, (0.0, 0.0, 0.15))}
    frames = {"tool": Frame((0.0, 0.0, 0.1), known=True), "targets": targets, "loads": loads}
    save_arm(desk, base=base, **frames)
    nominal = ec.load_robot(desk.folder / "robot.toml")
    out = desk.done(f"{QUICK} --poses 70 --kinds {kinds} --load none,heavy --elastic 2,3 -o plan.csv")
    assert "Expected accuracy" in out
    soft = {name: Compliance("linear", (5e-6,)) for name in ("2.theta", "3.theta")}
    known = {name: replace(f, rpy=f.rpy or (0.0, 0.0, 0.0), known=True) for name, f in nominal.frames.items()}
    actual = replace(nominal, elastic=soft).with_frames(known)
    table = pl.read_csv(desk.folder / "plan.csv")
    assert table.columns[:6] == [f"q{i}" for i in range(1, 7)]
    q = table.select(table.columns[:6]).to_numpy()
    measured = [name for name in table.columns[6:] if name not in ("target", "load") and "expected" not in name]
    columns = {name: np.zeros(70) for name in measured}
    for i, (target, load) in enumerate(zip(table["target"], table["load"], strict=True)):
        read = ec.simulate(actual, q[i : i + 1], kinds=kinds.split(","), target=target, load=load, noise=1e-5, seed=i)
        ec.save_measurements(read, nominal, desk.folder / "one.csv")
        row = pl.read_csv(desk.folder / "one.csv")
        for name, values in columns.items():
            values[i] = row[name][0]
        expected = [table[f"expected_{axis} [mm]"][i] for axis in "xyz"]
        assert expected == pytest.approx(1e3 * ec.predict(nominal, q[i], target=target, load=load)[0][0], abs=1e-3)
    filled = {name: pl.Series(values) for name, values in columns.items()}
    table.with_columns(**filled).write_csv(desk.folder / "fit.csv")
    result = json.loads(desk.done("calibrate robot.toml fit.csv --elastic 2,3 --json"))
    assert result["residuals"]["calibrated"]["mean"] < 3e-5
    for element in result["elastic"]:
        assert element["coefficients"][0] == pytest.approx(5e-6, abs=6.0 * element["std"][0])


def test_a_plan_that_is_not_filled_in_is_told_as_such(desk: Desk):
    save_arm(desk)
    desk.done(f"{QUICK} --poses 12 -o plan.csv")
    faults = desk.refused("calibrate robot.toml plan.csv")
    assert faults[0] == ("plan.csv: row 1, column 'x [mm]': expected a number, found an empty cell (and 11 more rows)")


def test_table_and_report_go_apart(desk: Desk):
    save_arm(desk)
    shown = desk.run(f"{QUICK} --poses 12 --seed 3")
    assert shown.status == 0 and "Expected accuracy" in shown.err and shown.out.count("\n") == 13
    assert shown.out.splitlines()[0] == "q1,q2,q3,q4,q5,q6,x [mm],y [mm],z [mm]"
    written = desk.run(f"{QUICK} --poses 12 --seed 3 -o sub/plan.csv")
    assert "Expected accuracy" in written.out and written.err == "sub/plan.csv\n"
    assert (desk.folder / "sub" / "plan.csv").read_text() == shown.out
    data = json.loads(desk.done(f"{QUICK} --poses 12 --seed 3 --json"))
    assert data["format"] == "elastocal-plan/1" and data["status"] == "planned"
    listed = np.array([line.split(",")[:6] for line in shown.out.splitlines()[1:]], dtype=float)
    assert np.array(data["poses"]["q"]) == pytest.approx(listed)
    assert len(data["parameters"]) == 27 and all(p["std"] > 0.0 for p in data["parameters"])
    assert data["settings"]["count"] == 12 and data["candidates"] == 100


def test_too_few_poses_end_with_status_one(desk: Desk):
    save_arm(desk)
    out = desk.done(f"{QUICK} --poses 5 -o plan.csv", 1)
    assert "5 poses cannot tell 27 parameters: it needs at least 9" in " ".join(out.split())
    assert (desk.folder / "plan.csv").is_file()


def test_own_candidates_a_start_and_a_distance(desk: Desk):
    save_arm(desk)
    q = ec.random_poses(arm(), 80, 1)
    pl.DataFrame({f"q{i} [deg]": np.degrees(v) for i, v in enumerate(q.T, start=1)}).write_csv(desk.folder / "own.csv")
    command = "plan robot.toml --candidates own.csv --poses 12 --apart 30deg --start=0,-90deg,0,0,0,0 --json"
    data = json.loads(desk.done(command))
    found = np.array(data["poses"]["q"])
    assert found == pytest.approx(q[np.array(data["poses"]["candidate"]) - 1])
    apart = np.abs(found[:, None] - found[None]).max(axis=2)[~np.eye(12, dtype=bool)]
    assert apart.min() >= np.radians(30.0)
    first = np.abs(found[0] - [0.0, -np.pi / 2.0, 0.0, 0.0, 0.0, 0.0]).max()
    assert data["travel"]["after"] == pytest.approx(first + np.abs(np.diff(found, axis=0)).max(axis=1).sum())


def test_poses_measured_before_count(desk: Desk):
    save_arm(desk, tool=TOOL)
    desk.done("simulate robot.toml --poses 20 --noise 0.03mm -o fit.csv")
    more = json.loads(desk.done(f"{QUICK} --poses 10 --measured fit.csv --json"))
    alone = json.loads(desk.done(f"{QUICK} --poses 10 --json"))
    assert more["measured"] == 20 and more["accuracy"] < 0.7 * alone["accuracy"]


def test_surroundings_are_kept(desk: Desk):
    save_arm(desk, tool=TOOL)
    around = "--floor 0.1m --keep-out=-2m,-0.4m,-2m,2m,0m,3m --keep-out 0.2m,2m,0.9m,2m,0m,3m --link-radius 8cm"
    seen = "--instrument 3m,0m,1m --range 1m,4m --cone 20deg --facing 80deg --facing-axis=-x"
    data = json.loads(desk.done(f"{QUICK} --poses 12 {around} {seen} --json"))
    home = replace(arm(), base=Frame((0.0, 0.0, 0.0), known=True), tool=TOOL)
    position, rotation = ec.predict(home, np.array(data["poses"]["q"]))
    towards = np.array([3.0, 0.0, 1.0]) - position
    distance = np.linalg.norm(towards, axis=1)
    assert position[:, 2].min() > 0.18 and distance.min() >= 1.0 and distance.max() <= 4.0
    assert (np.einsum("ni,ni->n", towards, -rotation[:, :, 0]) >= distance * np.cos(np.radians(80.0))).all()


def test_a_workspace_that_is_named_is_what_counts(desk: Desk):
    save_arm(desk, tool=TOOL)
    small = "--criterion accuracy --workspace 0.6m,0.9m,-0.2m,0.2m,0.4m,0.7m"
    one = json.loads(desk.done(f"{QUICK} --poses 15 {small} --json"))
    everywhere = json.loads(desk.done(f"{QUICK} --poses 15 --criterion accuracy --json"))
    assert one["accuracy"] != everywhere["accuracy"] and one["poses"]["candidate"] != everywhere["poses"]["candidate"]
    desk.write(where_csv="q1,q2,q3,q4,q5,q6\n0,0,0,0,0,0\n0.1,0.2,0.3,0.1,0.2,0.3\n")
    by_file = json.loads(desk.done(f"{QUICK} --poses 15 --criterion accuracy --workspace where.csv --json"))
    assert by_file["accuracy"] < everywhere["accuracy"]


LENGTHS = "(valid: m, mm, cm, um, µm, μm, in)"

REFUSED = {
    "--floor 9m": "found 0 candidates, expected at least 5: of ",
    "--instrument 3m,0m,0m --range 20m,21m": "found 0 candidates, expected at least 5: of ",
    "--cone 20deg": "cone: expected to know where the instrument stands: give its place in the base frame",
    "--keep-out 0,1,0,1": "--keep-out 0,1,0,1: expected 6 numbers with commas between them",
    "--keep-out 1,0,0,1,0,1": "keep-out 1: expected the lowest x and then the highest, found 1 m and 0 m",
    "--noise 0.03inch": f"--noise 0.03inch: no length unit 'inch'; did you mean 'in'? {LENGTHS}",
    "--noise 0mm": "noise: expected a positive number, found 0",
    "--kinds pose": "no kind 'pose'",
    "--apart 10mm": "--apart 10mm: no angle unit 'mm'",
    "--apart 170deg --pool 20": "found ",
    "--start 0,0,0": "--start 0,0,0: expected 2 numbers with commas between them",
    "--facing 200deg --instrument 1,1,1": "facing: expected an angle between 0 and 180 deg, found 200 deg",
    "--aim 1,1,1": "aim is of the middle of a cone, of which there is none: give a cone too",
    "--workspace 1,0,0,1,0,1": "--workspace 1,0,0,1,0,1: expected the lowest x and then the highest, found 1 m and 0 m",
    "--workspace 9,10,9,10,9,10": "found 0 candidates, expected at least 1: of ",
    "--workspace gone.csv": "gone.csv: no such file",
    "--candidates few.csv": "found 2 candidates, expected at least 5: of 2 candidates given; offer more",
    "--candidates few.csv --pool 20": "--pool is of random candidates: leave it or --candidates out",
    "--pool 4": "--pool 4: expected at least 5 candidates for 5 poses",
    "--load light": "--load: no load 'light'",
    "--target nest": "--target: no target 'nest' (valid: none)",
    "--station nort": "--station: no station 'nort'; did you mean 'north'? (valid: north)",
    "--elastic 9": "no element '9'",
    "--elastic elbow:step --transition 1,2": "transition: expected one torque for each element with a transition",
    "--identify 9.*": "--identify no parameter matches '9.*'",
    "--measured gone.csv": "gone.csv: no such file",
    "-o robot.toml": "-o robot.toml: expected a CSV file, as robot.csv, found .toml",
    "--candidates few.csv -o few.csv": "few.csv is an input, which a result never overwrites",
    "--tip l2": "robot.toml: --tip is for a URDF",
}


@pytest.mark.parametrize("options", REFUSED)
def test_what_cannot_be_is_refused_and_nothing_is_written(desk: Desk, options: str):
    desk.write(robot_toml=ROBOT, few_csv="q1,q2\n0,0\n0.1,0.2\n")
    before = contents(desk.folder)
    where = "" if "-o" in options.split() else " -o plan.csv"
    pool = "" if {"--pool", "--candidates"} & set(options.split()) else " --pool 60"
    fault = desk.refused(f"plan robot.toml --poses 5 {options}{pool}{where}")[0]
    assert fault.startswith(REFUSED[options])
    assert contents(desk.folder) == before


@pytest.mark.parametrize("options", ["", "--poses 0", "--poses five", "--poses 5 --criterion O6", "--poses 5 --sed 1"])
def test_usage_is_refused(desk: Desk, options: str):
    desk.write(robot_toml=ROBOT)
    assert desk.run(f"plan robot.toml {options}").status == 2


def test_all_names_that_do_not_exist_are_told(desk: Desk):
    desk.write(robot_toml=ROBOT)
    assert desk.refused("plan robot.toml --poses 5 --load light --target nest --station west") == [
        "--load: no load 'light' (valid: heavy)",
        "--target: no target 'nest' (valid: none)",
        "--station: no station 'west' (valid: north)",
    ]
