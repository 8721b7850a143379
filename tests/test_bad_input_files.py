"""Measurement files that are no table at all, and files given in the wrong place or twice."""

from __future__ import annotations

import polars as pl
import pytest

from support.files import DESCRIPTOR, ROBOT, TABLE, TRACKER, Desk, desk

__all__ = ["desk"]


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("fti.csv", "fti.csv: no such file; did you mean fit.csv? (there: fit.csv, held.csv)"),
        ("fit.parquet", "fit.parquet: no such file"),
        ("data/fit.csv", "data/fit.csv: no such file: there is no folder data"),
        (
            "robot.toml",
            'robot.toml: format: expected "elastocal-measurements/1", found "elastocal-robot/1": a robot file',
        ),
        (".", ".: expected a file, or a folder with Parquet files, found a folder without any"),
    ],
)
def test_data_that_are_not_there_are_refused_and_what_is_there_told(desk: Desk, name: str, fault: str):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE, held_csv=TABLE)
    assert desk.refused(f"calibrate robot.toml {name} -o out") == [fault]


def test_a_long_list_of_what_is_there_is_cut(desk: Desk):
    desk.write(robot_toml=ROBOT, **{f"day{i}_csv": TABLE for i in range(10, 20)})
    (fault,) = desk.refused("validate robot.toml tuesday.csv")
    assert fault.endswith(
        "(there: day10.csv, day11.csv, day12.csv, day13.csv, day14.csv, day15.csv, day16.csv, day17.csv, …)"
    )


@pytest.mark.parametrize("suffix", ["xlsx", "xls", "ods"])
def test_a_spreadsheet_is_refused_with_what_to_do(desk: Desk, suffix: str):
    desk.write(robot_toml=ROBOT, **{f"fit_{suffix}": b"PK\x03\x04\xff"})
    expected = f"fit.{suffix}: expected CSV, Parquet or a TOML descriptor: save the sheet as CSV"
    assert desk.refused(f"validate robot.toml fit.{suffix}") == [expected]


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (TABLE.encode("utf-16"), "UTF-16"),
        (TABLE.replace("x [mm]", "x [µm]").encode("latin-1"), "byte 0xb5 in line 1"),
        (TABLE.encode() + b"13,23,\xff,1,1\n", "byte 0xff in line 5"),
    ],
)
def test_a_table_in_another_encoding_is_refused(desk: Desk, content: bytes, found: str):
    desk.write(robot_toml=ROBOT, fit_csv=content)
    expected = f"fit.csv: expected UTF-8 text, found {found}: save it as UTF-8"
    assert desk.refused("validate robot.toml fit.csv") == [expected]


@pytest.mark.parametrize("text", [TABLE + '10,20,"a"b,1,1\n', TABLE + '10,20,"100,200,300\n'])
def test_text_that_is_no_table_is_refused(desk: Desk, text: str):
    desk.write(robot_toml=ROBOT, fit_csv=text)
    (fault,) = desk.refused("validate robot.toml fit.csv")
    assert fault.startswith(("fit.csv: row 4: expected 5 fields", "fit.csv: cannot be read as a table: "))


@pytest.mark.parametrize("content", [b"", b"junk", b"PAR1" + bytes(100) + b"PAR1"])
def test_a_broken_parquet_file_is_refused(desk: Desk, content: bytes):
    desk.write(robot_toml=ROBOT, fit_parquet=content)
    (fault,) = desk.refused("validate robot.toml fit.parquet")
    assert fault.startswith("fit.parquet: not a Parquet file: ")


@pytest.mark.parametrize(
    ("columns", "faults"),
    [
        ({"x": ["a"]}, ["row 1, column 'x': expected a number, found 'a'"]),
        (
            {"x": [None], "y": [float("nan")]},
            [
                "row 1, column 'x': expected a number, found an empty cell",
                "row 1, column 'y': expected a number, found nan",
            ],
        ),
        (
            {"x": [[1.0]], "y": [True]},
            ["column 'x': expected numbers, found List(Float64)", "column 'y': expected numbers, found Boolean"],
        ),
        ({"station": [["north"]]}, ["column 'station': expected names, found List(String)"]),
        ({"x": [], "y": [], "z": [], "q1": [], "q2": []}, ["expected at least one row of measurements, found none"]),
    ],
)
def test_a_parquet_file_of_other_things_is_refused(desk: Desk, columns: dict[str, list[object]], faults: list[str]):
    whole = {"q1": [0.1], "q2": [0.2], "x": [0.1], "y": [0.2], "z": [0.3]} | columns
    pl.DataFrame(whole).write_parquet(desk.folder / "fit.parquet")
    desk.write(robot_toml=ROBOT)
    assert desk.refused("validate robot.toml fit.parquet") == [f"fit.parquet: {fault}" for fault in faults]


def test_no_data_are_refused_with_where_they_go(desk: Desk):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    expected = "expected at least one file of measurements right after the robot, before options; found none"
    assert desk.refused("validate robot.toml") == [expected]
    assert desk.refused("calibrate robot.toml --held-out fit.csv -o out") == [expected]


@pytest.mark.parametrize("again", ["fit.csv", "./fit.csv", "../{}/fit.csv"])
def test_a_file_given_twice_is_refused(desk: Desk, again: str):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    again = again.format(desk.folder.name)
    faults = desk.refused(f"validate robot.toml fit.csv {again}")
    assert faults[0] == "fit.csv is given 2 times: leave all but one out"
    assert desk.refused(f"calibrate robot.toml fit.csv --held-out {again}") == [
        f"{again.removeprefix('./')} is both fitted and held out: choose one"
    ]


@pytest.mark.parametrize("inputs", ["robot.toml", "held.csv", "tracker.toml", "tracker.csv"])
def test_a_result_overwrites_no_input_not_even_the_file_that_a_descriptor_describes(desk: Desk, inputs: str):
    desk.write(robot_toml=ROBOT, held_csv=TABLE, tracker_csv=TRACKER, tracker_toml=DESCRIPTOR)
    expected = f"{inputs} is an input, which a result never overwrites: choose another place (-o)"
    assert desk.refused(f"validate robot.toml held.csv tracker.toml -o {inputs}") == [expected]
