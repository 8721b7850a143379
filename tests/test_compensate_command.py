"""`elastocal compensate`: tables in and out, long ones in blocks, faults by their rows, warnings on the TCP."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.compensation import run as running
from elastocal.io import target_files
from elastocal.robot import Compliance, Frame, Payload, Robot
from support.files import Desk, desk, flawed
from support.robots import arm

__all__ = ["desk"]

MIDDLE = (0.2, -0.7, 1.0, 0.4, 0.8, 0.3)
START = "--start 0.2,-0.7,1.0,0.4,0.8,0.3"


def nominal_arm() -> Robot:
    return replace(
        arm(),
        tool=Frame((0.0, 0.0, 0.1), (0.0, 0.0, 0.0), known=True),
        targets={"nest": Frame((0.05, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)},
        loads={"heavy": Payload(20.0, (0.0, 0.0, 0.1))},
    )


def actual_arm() -> Robot:
    built = flawed(nominal_arm(), np.random.default_rng(0), 5e-4)
    seat = Frame((1.0, 0.5, 0.0), (0.0, 0.0, 1.0), known=True)
    return replace(built, base=seat, elastic={"2.theta": Compliance("linear", (4e-6,))})


def program(count: int) -> np.ndarray:
    return np.array(MIDDLE) + np.random.default_rng(0).uniform(-0.3, 0.3, (count, 6))


def columns_of(q: np.ndarray) -> dict[str, np.ndarray]:
    return {f"q{i} [deg]": np.degrees(values) for i, values in enumerate(q.T, start=1)}


def pose_columns(count: int) -> dict[str, np.ndarray]:
    from scipy.spatial.transform import Rotation

    positions, rotations = ec.predict(nominal_arm(), program(count))
    quaternions = Rotation.from_matrix(rotations).as_quat()
    columns = {f"{axis} [mm]": 1e3 * values for axis, values in zip("xyz", positions.T, strict=True)}
    return columns | dict(zip(("qx", "qy", "qz", "qw"), quaternions.T, strict=True))


@pytest.fixture
def shop(desk: Desk) -> Desk:
    """robot.toml, actual.toml, and the same targets as a program and as poses."""
    ec.save_robot(nominal_arm(), desk.folder / "robot.toml")
    ec.save_robot(actual_arm(), desk.folder / "actual.toml")
    pl.DataFrame(columns_of(program(40))).write_csv(desk.folder / "program.csv")
    pl.DataFrame(pose_columns(40)).write_csv(desk.folder / "poses.csv")
    return desk


def read(path: Path) -> pl.DataFrame:
    return pl.read_parquet(path) if path.suffix == ".parquet" else pl.read_csv(path)


def test_a_program_and_its_poses_give_the_same_commands(shop: Desk):
    shop.done("compensate actual.toml program.csv --nominal robot.toml -o one.csv")
    shop.done(f"compensate actual.toml poses.csv --nominal robot.toml {START} -o two.parquet")
    one, two = read(shop.folder / "one.csv"), read(shop.folder / "two.parquet")
    assert one.columns == two.columns
    assert one.columns[:7] == ["q1", "q2", "q3", "q4", "q5", "q6", "reached"]
    assert one["reached"].all()
    np.testing.assert_allclose(one.select("^q[1-6]$").to_numpy(), two.select("^q[1-6]$").to_numpy(), atol=1e-8)
    q = one.select("^q[1-6]$").to_numpy()
    there, _ = ec.predict(replace(actual_arm(), base=Frame()), q)
    np.testing.assert_allclose(there, ec.predict(nominal_arm(), program(40))[0], atol=2e-9)
    fake = one.select("^fake_[xyz].*$").to_numpy() / 1e3
    np.testing.assert_allclose(fake, ec.predict(nominal_arm(), q)[0], atol=1e-9)


def test_the_table_goes_to_standard_output_and_the_summary_beside_it(shop: Desk):
    ran = shop.run("compensate actual.toml program.csv --nominal robot.toml")
    assert ran.status == 0
    assert ran.out.startswith("q1,q2,q3,q4,q5,q6,reached,")
    assert len(ran.out.splitlines()) == 41
    assert "40 of 40 targets reached" in ran.err


def test_json_is_the_result_and_nothing_else(shop: Desk):
    found = json.loads(shop.done("compensate actual.toml program.csv --nominal robot.toml --json"))
    assert found["format"] == "elastocal-compensation/1"
    assert found["targets"] == found["reached"] == len(found["rows"]) == 40
    assert found["error_before"]["mean"] > 1e-3
    assert found["error_after"]["max"] < 1e-9
    assert "All 40 targets reached" in found["verdict"]


def test_a_target_out_of_reach_keeps_its_row_and_exits_1(shop: Desk):
    shop.write(far_csv="x,y,z\n0.8,0.1,0.6\n5,0,0\n0.7,0.2,0.6\n")
    shown = shop.done("compensate actual.toml far.csv --nominal robot.toml -o out.csv", status=1)
    found = read(shop.folder / "out.csv")
    assert found["reached"].to_list() == [True, False, True]
    assert found["note"][1].endswith("mm left")
    assert found["correction_angle [mrad]"].is_null().all()
    assert "2 of 3 targets reached" in shown
    assert "Target 2:" in shown


def test_payload_tcp_and_frame_are_options_too(shop: Desk):
    targets = pose_columns(5)
    whole = targets | {"load": ["heavy"] * 5, "target": ["nest"] * 5}
    pl.DataFrame(whole).write_csv(shop.folder / "named.csv")
    pl.DataFrame(targets).write_csv(shop.folder / "plain.csv")
    shop.done(f"compensate actual.toml named.csv --nominal robot.toml {START} -o one.csv")
    shop.done(f"compensate actual.toml plain.csv --nominal robot.toml {START} --load heavy --target nest -o two.csv")
    assert read(shop.folder / "one.csv").equals(read(shop.folder / "two.csv"))
    seat = actual_arm().base
    positions = np.stack([targets[f"{axis} [mm]"] for axis in "xyz"], axis=1) / 1e3
    moved = positions @ seat.rotation.T + seat.translation
    for columns, file in ((positions, "base.csv"), (moved, "instrument.csv")):
        pl.DataFrame(dict(zip("xyz", columns.T, strict=True))).write_csv(shop.folder / file)
    shop.done(f"compensate actual.toml base.csv --nominal robot.toml {START} -o base_out.csv")
    shop.done(f"compensate actual.toml instrument.csv --nominal robot.toml {START} --frame instrument -o out.csv")
    one, other = (read(shop.folder / name).select("^q[1-6]$").to_numpy() for name in ("base_out.csv", "out.csv"))
    np.testing.assert_allclose(one, other, atol=1e-4)  # of all that reach a point, nearly the same


def test_a_tool_is_given_in_place_of_the_robots(shop: Desk):
    shop.done("compensate actual.toml program.csv --nominal robot.toml --tool 0mm,0mm,100mm,0deg,0deg,0deg -o one.csv")
    shop.done("compensate actual.toml program.csv --nominal robot.toml -o two.csv")
    shop.done("compensate actual.toml program.csv --nominal robot.toml --tool 0,0,0.3,0,0,0 -o three.csv")
    one, two, three = (read(shop.folder / f"{name}.csv") for name in ("one", "two", "three"))
    np.testing.assert_allclose(one["q1"], two["q1"], atol=1e-9)
    assert np.abs(one["fake_x [mm]"] - three["fake_x [mm]"]).max() > 10.0


def test_a_tool_has_no_targets_on_it(shop: Desk):
    pl.DataFrame(pose_columns(2) | {"target": ["nest"] * 2}).write_csv(shop.folder / "named.csv")
    (fault,) = shop.refused("compensate actual.toml named.csv --nominal robot.toml --tool 0,0,0.3,0,0,0")
    assert "arm has no target 'nest' (valid: none)" in fault


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_long_tables_are_read_in_blocks(shop: Desk, monkeypatch: pytest.MonkeyPatch, suffix: str):
    """Pieces of a file end anywhere, blocks do not."""
    frame = pl.DataFrame(columns_of(program(400)) | {"load": ["heavy", None] * 200})
    path = shop.folder / f"long.{suffix}"
    frame.write_csv(path) if suffix == "csv" else frame.write_parquet(path)
    shop.done(f"compensate actual.toml long.{suffix} --nominal robot.toml -o whole.{suffix}")
    monkeypatch.setattr(target_files, "PIECE", 1000)
    monkeypatch.setattr(target_files, "BLOCK", 7)
    monkeypatch.setattr(target_files.TargetFile.blocks, "__defaults__", (37,))
    shop.done(f"compensate actual.toml long.{suffix} --nominal robot.toml -o pieces.{suffix}")
    whole, pieces = (read(shop.folder / f"{name}.{suffix}") for name in ("whole", "pieces"))
    assert whole.height == pieces.height == 400
    np.testing.assert_allclose(whole.select("^q[1-6]$").to_numpy(), pieces.select("^q[1-6]$").to_numpy(), atol=1e-12)


def test_a_described_file_is_read_too(shop: Desk):
    rows = np.column_stack([program(3), ec.predict(nominal_arm(), program(3))[0]])
    lines = ["a;b;c;d;e;f;x;y;z", *(";".join(f"{x:.9f}".replace(".", ",") for x in row) for row in rows)]
    shop.write(
        source_csv="\n".join(lines),
        described_toml='format = "elastocal-measurements/1"\nfile = "source.csv"\ndelimiter = ";"\ndecimal = ","\n'
        '[columns]\nq = { columns = ["a", "b", "c", "d", "e", "f"], unit = "rad" }\n'
        'position = { columns = ["x", "y", "z"], unit = "m" }\n',
    )
    ran = shop.run("compensate actual.toml described.toml --nominal robot.toml -o out.csv")
    assert ran.status == 0, ran.err
    assert read(shop.folder / "out.csv").height == 3


def test_a_fault_deep_in_a_file_is_named_and_nothing_is_left(shop: Desk, monkeypatch: pytest.MonkeyPatch):
    frame = pl.DataFrame(columns_of(program(300))).cast(pl.String)
    for row, text, said in ((250, "abc", "found 'abc'"), (281, "1e9", "joint 3 within its limits")):
        spoiled = frame.with_columns(
            pl.when(pl.int_range(300) == row).then(pl.lit(text)).otherwise(pl.col("q3 [deg]")).alias("q3 [deg]")
        )
        spoiled.write_csv(shop.folder / "spoiled.csv")
        monkeypatch.setattr(target_files.TargetFile.blocks, "__defaults__", (50,))
        (fault,) = shop.refused("compensate actual.toml spoiled.csv --nominal robot.toml -o out.csv")
        assert f"spoiled.csv: row {row + 1}, column 'q3 [deg]'" in fault
        assert said in fault
        (fault,) = shop.refused("compensate actual.toml spoiled.csv --nominal robot.toml")
        assert f"row {row + 1}" in fault


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "expected at least one target, found none"),
        ("x,y,z\n", "expected at least one target, found none"),
        ("x,y\n1,2\n", "expected the columns x, y, z, or none of them: z missing"),
        ("a,b\n1,2\n", "expected targets: columns x, y, z, or joint positions q1 … qn"),
        ("qw,qx,qy,qz\n1,0,0,0\n", "expected the columns x, y, z beside qw, qx, qy, qz"),
        ("x,y,z,qw,qx,qy,qz\n0.8,0,0.5,2,0,0,0\n", "row 1, column 'qw, qx, qy, qz': expected a quaternion, length 1"),
        ("x,y,z,load\n0.8,0,0.5,\n0.8,0,0.5,light\n", "row 2, column 'load': arm has no load 'light'"),
        ("x,y,z,target\n0.8,0,0.5,nset\n", "arm has no target 'nset'; did you mean 'nest'?"),
        ("x [furlong],y,z\n0.8,0,0.5\n", "no length unit 'furlong'"),
        ("x,y,z\n0.8,0,0.5\n800,0,500\n", "row 2, column 'x': expected at most 200 m (for millimetres"),
        ("x;y;z\n0,8;0;0,5\n", 'expected "," between columns, found ";"'),
        ("x,y,z\n0.8,0,0.5\n0.8,0,0.5,7\n", "row 2: expected 3 fields as in the header, found 4"),
        ("x,y,z\n0.8,0,0.5\n0.8,,0.5\n", "row 2, column 'y': expected a number, found an empty cell"),
        ("x,y,z\n0.8,0,0.5\n,,\n0.8,0,0.5\n", "row 2: expected measurements, found none"),
        ("q1,q2\n0,0\n", "expected the columns q1 … q6 of the 6 joints of arm"),
        (b"x,y,z\n0.8,0,\xff\n", "expected UTF-8 text, found byte 0xff"),
    ],
)
def test_faulty_tables_are_refused(shop: Desk, table: str | bytes, message: str):
    shop.write(bad_csv=table)
    faults = shop.refused("compensate actual.toml bad.csv --nominal robot.toml -o out.csv")
    assert message in "\n".join(faults)
    assert all("bad.csv" in fault for fault in faults)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("program.csv", "are where the nominal robot would be, which is not known: give it (--nominal ROBOT)"),
        ("missing.csv", "missing.csv: no such file"),
        ("poses.csv --nominal missing.toml", "missing.toml: no such file"),
        ("poses.csv --load light", "--load: arm has no load 'light'"),
        ("poses.csv --target tip", "--target: arm has no target 'tip'"),
        ("poses.csv --frame instrument --station west", "--station: arm has no station 'west'"),
        ("poses.csv --tool 0,0,0", "--tool 0,0,0: expected 6 numbers"),
        ("poses.csv --tool 0,0,0,0,0,0 --target nest", "which --tool takes away: choose one"),
        ("poses.csv --start 0,0", "--start 0,0: expected 6 numbers"),
        ("poses.csv --start 0mm,0,0,0,0,0", "no angle unit 'mm'"),
        ("poses.csv -o poses.csv", "is an input, which a result never overwrites"),
        ("poses.csv -o out.xlsx", "expected a CSV (.csv) or Parquet (.parquet) file, found .xlsx"),
    ],
)
def test_faulty_requests_are_refused(shop: Desk, options: str, message: str):
    assert message in "\n".join(shop.refused(f"compensate actual.toml {options}"))


def calibrated(shop: Desk, kinds: tuple[str, ...], target: str | None) -> None:
    nominal = nominal_arm() if target else replace(nominal_arm(), targets={})
    ec.save_robot(nominal, shop.folder / "robot.toml")
    data = ec.simulate(
        actual_arm(), ec.random_poses(nominal, 40, 1), kinds=kinds, noise=1e-5, noise_angle=1e-5, target=target
    )
    ec.save_measurements(data, nominal, shop.folder / "fit.csv")
    shop.done("calibrate robot.toml fit.csv --elastic 2 -o result")


def test_the_nominal_robot_is_that_of_the_calibration_beside_the_robot(shop: Desk):
    calibrated(shop, ("position", "orientation"), None)
    shop.done("compensate result/robot.toml program.csv -o one.csv")
    shop.done("compensate result/robot.toml program.csv --nominal robot.toml -o two.csv")
    one, two = read(shop.folder / "one.csv"), read(shop.folder / "two.csv")
    np.testing.assert_allclose(one.select("^q[1-6]$").to_numpy(), two.select("^q[1-6]$").to_numpy(), atol=1e-9)


def warnings_of(shop: Desk, command: str) -> str:
    ran = shop.run(command)
    assert ran.status in (0, 1), ran.err
    return " ".join(json.loads(ran.out)["warnings"])


def test_a_tcp_that_was_not_calibrated_is_warned_of(shop: Desk):
    calibrated(shop, ("position", "orientation"), "nest")
    told = warnings_of(shop, "compensate result/robot.toml poses.csv --json")
    assert "The TCP is the tool's origin, 50.0 mm from what was calibrated, target nest" in told
    assert warnings_of(shop, "compensate result/robot.toml poses.csv --target nest --json") == ""
    told = warnings_of(shop, "compensate result/robot.toml poses.csv --tool 0,0,0.3,0,0,0 --json")
    assert "from what was calibrated" in told
    told = warnings_of(shop, "compensate result/robot.toml poses.csv --tool 0.05,0,0.1,0,0,1 --json")
    assert "turned against what was calibrated" in told


def test_orientations_that_were_not_calibrated_are_warned_of(shop: Desk):
    calibrated(shop, ("position",), None)
    assert "Only positions were calibrated" in warnings_of(shop, "compensate result/robot.toml poses.csv --json")
    shop.write(points_csv="x,y,z\n0.8,0.1,0.6\n")
    assert warnings_of(shop, "compensate result/robot.toml points.csv --json") == ""


def test_without_a_calibration_beside_it_nothing_is_said_of_the_tcp(shop: Desk):
    assert warnings_of(shop, "compensate actual.toml program.csv --nominal robot.toml --json") == ""


def test_a_result_of_another_robot_is_left_out_of_account(shop: Desk):
    calibrated(shop, ("position",), None)
    ec.save_robot(actual_arm(), shop.folder / "result" / "robot.toml")
    told = warnings_of(shop, "compensate result/robot.toml poses.csv --json")
    assert "does not belong to" in told
    assert "left out of account" in told


def test_blocks_are_as_the_program_makes_them():
    assert target_files.BLOCK == running.BLOCK
