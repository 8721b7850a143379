"""Parquet data sets: read in parts as they would be read whole, with every fault named by its row of the file."""

from __future__ import annotations

import json
from dataclasses import fields
from io import BytesIO
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.errors import InputError
from elastocal.io import data_files, measurements_to_csv, open_measurements, too_large
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.partitions import Partitions
from elastocal.robot import Frame, Payload, Robot
from elastocal.simulation import random_poses, simulate, survey
from support.files import Desk, contents, desk, save_simulated
from support.robots import arm, placed

__all__ = ["desk"]

ROWS = 260


def rich_robot() -> Robot:
    """An arm with two targets, a payload and two stations."""
    base = placed(arm(), np.random.default_rng(0))
    return Robot(
        **{
            **vars(base),
            "targets": {"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.1, 0.0))},
            "loads": {"heavy": Payload(5.0)},
            "stations": {"north": Frame((1.0, 0.0, 0.0), known=True), "south": Frame((0.0, 1.0, 0.0), known=True)},
        }
    )


def table(robot: Robot, rows: int = ROWS, seed: int = 0) -> pl.DataFrame:
    """Measurements with every column that there may be."""
    rng = np.random.default_rng(seed)
    data = simulate(
        robot,
        random_poses(robot, rows, seed),
        kinds=("position", "orientation", "distance"),
        noise=1e-5,
        noise_angle=1e-5,
        state_sigma=True,
        station="north",
        target="a",
        wrench=rng.normal(size=(rows, 6)),
        seed=seed,
    )
    names = {
        "target": Labels.of(rng.choice(["a", "b"], rows).tolist()),
        "load": Labels.of([str(name) if name else None for name in rng.choice(["heavy", ""], rows)]),
        "station": Labels.of(rng.choice(["north", "south"], rows).tolist()),
        "pose": rng.integers(0, 50, rows),
        "temperature": rng.normal(20.0, 1.0, rows),
    }
    return pl.read_csv(BytesIO(measurements_to_csv(Measurements(**{**vars(data), **names}), robot)))


@pytest.fixture
def data_set(tmp_path: Path) -> tuple[Path, Robot, Measurements]:
    """A folder of two files, the robot, and all rows as they are read whole."""
    robot, folder = rich_robot(), tmp_path / "set"
    (folder / "2026").mkdir(parents=True)
    rows = table(robot)
    rows[:100].write_parquet(folder / "2026" / "a.parquet", row_group_size=30)
    rows[100:].with_columns(note=pl.lit("not of interest")).write_parquet(folder / "b.parquet", row_group_size=50)
    (folder / "_metadata.parquet").write_text("of another tool")
    (folder / "README.txt").write_text("what this is")
    files = data_files([folder])
    return folder, robot, ec.load_measurements(files, robot)


def assert_same(one: Measurements, other: Measurements) -> None:
    """Check that measurements are the same but for the numbers of poses."""
    for field in fields(Measurements):
        first, second = getattr(one, field.name), getattr(other, field.name)
        assert (first is None) == (second is None), field.name
        if isinstance(first, Labels):
            assert [first.name(code) for code in first.codes] == [second.name(code) for code in second.codes]
        elif first is not None and field.name != "pose":
            np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("part_rows", [7, 30, 70, 100, 1000])
def test_parts_are_the_whole(data_set: tuple[Path, Robot, Measurements], part_rows: int):
    folder, robot, whole = data_set
    found = ec.scan_measurements(folder, robot, part_rows=part_rows)
    assert isinstance(found, ec.Partitions)
    assert len(found) == ROWS
    assert len(found.parts) == sum(-(-rows // part_rows) for rows in (100, 160))
    assert_same(whole, concatenate([part.read() for part in found.parts]))
    assert_same(whole, found.sample)
    assert max(part.rows for part in found.parts) <= part_rows


def test_repeats_keep_one_number_within_a_part(data_set: tuple[Path, Robot, Measurements]):
    folder, robot, whole = data_set
    part = ec.scan_measurements(folder, robot, part_rows=80).parts[1].read()
    here = whole.pose[80:100]
    same = part.pose[:, None] == part.pose[None]
    np.testing.assert_array_equal(same, here[:, None] == here[None])


def test_a_large_set_has_a_sample_of_rows_from_all_parts(
    data_set: tuple[Path, Robot, Measurements], monkeypatch: pytest.MonkeyPatch
):
    folder, robot, whole = data_set
    monkeypatch.setattr("elastocal.io.partition_files.SAMPLE", 40)
    monkeypatch.setattr("elastocal.partitions.FEWEST", 1)
    sample = ec.scan_measurements(folder, robot, part_rows=60).sample
    assert 40 <= len(sample) < 100
    assert {sample.origin(i)[0] for i in range(len(sample))} == {"a.parquet", "b.parquet"}
    places = {whole.origin(i): i for i in range(ROWS)}
    rows = np.array([places[sample.origin(i)] for i in range(len(sample))])
    assert (np.diff(rows) > 0).all()
    assert_same(whole.take(rows), sample)
    assert len(set((rows // 60).tolist())) == 5


def test_columns_of_other_things_are_not_read(data_set: tuple[Path, Robot, Measurements]):
    folder, robot, _ = data_set
    found = ec.scan_measurements(folder, robot)
    assert all("note" not in part.columns for part in found.parts)


FAULTS = {
    "a joint out of its limits": ("q2 [deg]", {70: 100.0, 71: 101.0}, "row 71, column 'q2 [deg]': expected joint 2"),
    "no number": ("x [mm]", {205: float("nan")}, "row 206, column 'x [mm]': expected a number, found nan"),
    "an unknown target": ("target", {133: "c"}, "row 134, column 'target': arm has no target 'c'"),
    "no target": ("target", {133: None}, "row 134, column 'target': expected one of a, b, found an empty cell"),
    "a negative deviation": (
        "sigma [mm]",
        {10: -1.0},
        "row 11, column 'sigma [mm]': expected a positive number, found",
    ),
    "no quaternion": ("qw", {60: 3.0}, "row 61, column 'qw, qx, qy, qz': expected a quaternion, length 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_with_its_row_of_the_file(tmp_path: Path, fault: str):
    column, values, said = FAULTS[fault]
    robot, rows = rich_robot(), table(rich_robot())
    changed = rows[column].to_list()
    for row, value in values.items():
        changed[row] = value
    path = tmp_path / "fit.parquet"
    rows.with_columns(pl.Series(column, changed, dtype=rows[column].dtype)).write_parquet(path)
    with pytest.raises(InputError) as whole:
        ec.load_measurements(path, robot)
    with pytest.raises(InputError) as parts:
        ec.scan_measurements(path, robot, part_rows=50)
    assert parts.value.faults == whole.value.faults
    assert said in parts.value.faults[0]


def test_faults_of_all_parts_and_files_are_told_at_once(tmp_path: Path):
    robot, rows = rich_robot(), table(rich_robot())
    bad = rows.with_columns(
        pl.when(pl.int_range(pl.len()) % 50 == 7).then(1e6).otherwise(pl.col("y [mm]")).alias("y [mm]")
    )
    for name in ("a", "b"):
        bad.write_parquet(tmp_path / f"{name}.parquet")
    with pytest.raises(InputError) as error:
        ec.scan_measurements(tmp_path, robot, part_rows=50)
    faults = error.value.faults
    assert len(faults) == 12
    assert [fault.split(": ")[1].split(",")[0] for fault in faults] == 2 * [f"row {8 + 50 * i}" for i in range(6)]
    with pytest.raises(InputError) as error:
        ec.scan_measurements(tmp_path, robot, part_rows=10)
    many = rows.with_columns(pl.lit(1e6).alias("y [mm]"))
    many.write_parquet(tmp_path / "a.parquet")
    with pytest.raises(InputError) as error:
        ec.scan_measurements(tmp_path, robot, part_rows=10)
    assert len(error.value.faults) == 21
    assert error.value.faults[-1] == "and 12 more faults"


def test_copied_and_empty_rows_are_found_within_parts(tmp_path: Path):
    robot, rows = rich_robot(), table(rich_robot())
    empty = rows.head(1).select(pl.lit(None, dtype=rows[name].dtype).alias(name) for name in rows.columns)
    pl.concat([rows[:60], rows[55:56], rows[60:]]).write_parquet(tmp_path / "copied.parquet")
    pl.concat([rows[:60], empty, rows[60:]]).write_parquet(tmp_path / "empty.parquet")
    with pytest.raises(InputError, match="row 61 is a copy of row 56, to the last digit: leave it out"):
        ec.scan_measurements(tmp_path / "copied.parquet", robot, part_rows=100)
    with pytest.raises(InputError, match="row 61: expected measurements, found none"):
        ec.scan_measurements(tmp_path / "empty.parquet", robot, part_rows=50)


def test_a_fault_of_the_columns_is_told_once(tmp_path: Path):
    robot = rich_robot()
    rows = table(robot).rename({"q3 [deg]": "q3_deg", "x [mm]": "X"})
    rows.write_parquet(tmp_path / "fit.parquet")
    with pytest.raises(InputError) as whole:
        ec.load_measurements(tmp_path / "fit.parquet", robot)
    with pytest.raises(InputError) as parts:
        ec.scan_measurements(tmp_path / "fit.parquet", robot, part_rows=20)
    assert parts.value.faults == whole.value.faults


def test_what_is_no_data_set_is_refused(tmp_path: Path):
    robot = rich_robot()
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken.parquet").write_bytes(b"PAR1 and no more")
    table(robot)[:0].write_parquet(tmp_path / "none.parquet")
    (tmp_path / "fit.csv").write_text("q1\n")
    refused = {
        "empty": "expected a file, or a folder with Parquet files, found a folder without any",
        "broken.parquet": "broken.parquet: not a Parquet file: ",
        "none.parquet": "none.parquet: expected at least one row of measurements, found none",
        "fit.csv": "fit.csv: expected a Parquet file, found .csv",
        "gone.parquet": "gone.parquet: no such file",
    }
    for name, said in refused.items():
        with pytest.raises(InputError) as error:
            ec.scan_measurements(tmp_path / name, robot)
        assert said in str(error.value)
    with pytest.raises(InputError, match="part_rows is 0: expected at least 1"):
        ec.scan_measurements(tmp_path, robot, part_rows=0)
    table(robot).write_parquet(tmp_path / "one.parquet")
    with pytest.raises(InputError, match="is given 2 times: leave all but one out"):
        ec.scan_measurements([tmp_path / "one.parquet", tmp_path / "one.parquet"], robot)


def test_only_what_is_large_is_read_in_parts(
    data_set: tuple[Path, Robot, Measurements], monkeypatch: pytest.MonkeyPatch
):
    folder, robot, whole = data_set
    files = data_files([folder])
    assert [path.name for path in files] == ["a.parquet", "b.parquet"]
    assert_same(whole, open_measurements([folder], robot))
    monkeypatch.setattr("elastocal.io.partition_files.HELD_ROWS", 200)
    assert too_large(files)
    assert not too_large(files[:1])
    told: list[tuple[int, int]] = []
    found = open_measurements([folder], robot, on_part=lambda done, count: told.append((done, count)))
    assert isinstance(found, Partitions)
    assert told == [(1, 2), (2, 2)]


@pytest.fixture
def large(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> Desk:
    """A folder with a robot, its measurements as CSV and as Parquet, and few rows enough to be many."""
    monkeypatch.setattr("elastocal.io.partition_files.HELD_ROWS", 100)
    save_simulated(desk.folder, fit=150, held_out=120)
    robot = ec.load_robot(desk.folder / "robot.toml")
    for name in ("fit", "held_out"):
        ec.save_measurements(
            ec.load_measurements(desk.folder / f"{name}.csv", robot), robot, desk.folder / f"{name}.parquet"
        )
    return desk


def test_the_command_reads_large_data_in_parts(large: Desk):
    command = "calibrate robot.toml {0}.{2} --held-out {1}.{2} --elastic 2,3 --jobs 1 -o {2}"
    for suffix in ("csv", "parquet"):
        large.done(command.format("fit", "held_out", suffix))
    one, other = (json.loads((large.folder / name / "result.json").read_text()) for name in ("csv", "parquet"))
    assert one["streamed"] is None
    assert other["streamed"] == {"rows": 150, "parts": 1, "sample": 150, "outliers": 0, "rejected": 0}
    for p, q in zip(one["parameters"], other["parameters"], strict=True):
        if p["std"]:
            assert abs(p["identified"] - q["identified"]) < 1e-3 * p["std"]
    for name in ("calibrated", "held_out"):
        assert other["residuals"][name] == pytest.approx(one["residuals"][name], rel=1e-6)
    assert len(other["data_sha256"]) == 2
    assert len((large.folder / "parquet" / "residuals.csv").read_text().splitlines()) == 271


def test_a_folder_is_a_data_set(large: Desk):
    (large.folder / "set").mkdir()
    for name in ("fit", "held_out"):
        (large.folder / f"{name}.parquet").rename(large.folder / "set" / f"{name}.parquet")
    result = json.loads(large.done("calibrate robot.toml set --elastic 2,3 --jobs 1 --json"))
    assert result["streamed"]["rows"] == 270
    assert result["settings"]["data"] == ["set"]
    assert len(result["data_sha256"]) == 2


def test_the_command_says_what_large_data_cannot_be_asked(large: Desk):
    (fault,) = large.refused("calibrate robot.toml fit.parquet --holdout 0.3 --jobs 1")
    assert "150 rows are not held in memory at once" in fault
    assert fault.endswith("give these as held-out rows (--held-out)")
    faults = large.refused("calibrate robot.toml fit.parquet --held-out fit.parquet --jobs 1")
    assert faults == ["fit.parquet is both fitted and held out: choose one"]


def simulated(desk: Desk, name: str, options: str = "") -> Measurements:
    desk.done(f"simulate robot.toml --poses 400 --noise 0.1mm --seed 3 -o {name} {options}")
    return ec.load_measurements(desk.folder / name, ec.load_robot(desk.folder / "robot.toml"))


def test_simulate_writes_parquet_as_it_writes_csv(desk: Desk):
    save_simulated(desk.folder)
    one, other = simulated(desk, "one.csv"), simulated(desk, "one.parquet")
    np.testing.assert_array_equal(one.q, other.q)
    np.testing.assert_array_equal(one.position, other.position)


def test_simulate_writes_large_tables_in_blocks(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("elastocal.io.ROW_GROUP", 150)
    save_simulated(desk.folder)
    data = simulated(desk, "one.parquet")
    assert len(np.unique(data.q, axis=0)) == 400
    again, other = simulated(desk, "two.parquet"), simulated(desk, "three.parquet", "--rounding 1mm")
    np.testing.assert_array_equal(data.position, again.position)
    np.testing.assert_array_equal(data.q, other.q)
    assert np.abs(data.position - other.position).max() < 0.6e-3


def test_a_table_that_cannot_be_made_leaves_nothing(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("elastocal.io.ROW_GROUP", 50)
    save_simulated(desk.folder)
    calls: list[int] = []

    def failing(*arguments: object, **options: object) -> Measurements:
        calls.append(1)
        if len(calls) == 3:
            raise InputError("found 3 of 50 poses")
        return survey(*arguments, **options)

    monkeypatch.setattr("elastocal.simulation.survey", failing)
    before = contents(desk.folder)
    assert desk.refused("simulate robot.toml --poses 400 -o fit.parquet") == ["found 3 of 50 poses"]
    assert contents(desk.folder) == before
    (desk.folder / "robot.parquet").write_bytes((desk.folder / "robot.toml").read_bytes())
    assert "expected a file to write, found a folder" in desk.refused("simulate robot.toml --poses 4 -o .")[0]
