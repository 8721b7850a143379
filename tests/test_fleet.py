"""Fleets: one result for each row, faults told together, what is done not done again."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.fleet.siblings import LEVEL, robust_scores, siblings_of, threshold
from elastocal.identification import SavedResult
from elastocal.io.manifests import OPTIONS, read_manifest
from support.files import Desk, contents, desk
from support.fleets import save_fleet

__all__ = ["desk"]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fleet of eight, three measured twice, one of them loose by then; its results in out/."""
    folder = tmp_path_factory.mktemp("fleet")
    save_fleet(folder, 8, again=(1, 4), loose=(2,))
    ran = Desk(folder).run("fleet fleet.csv -o out --jobs 1")
    assert ran.status == 0, ran.err
    return folder


def copied(fleet: Path, folder: Path) -> Desk:
    """The fleet with its results, in a folder of the test's own."""
    shutil.copytree(fleet, folder, dirs_exist_ok=True)
    return Desk(folder)


def times(folder: Path) -> dict[str, int]:
    """When each result was written."""
    return {str(path.relative_to(folder)): path.stat().st_mtime_ns for path in folder.rglob("result.json")}


def parameters(folder: Path) -> list[object]:
    return json.loads((folder / "result.json").read_text())["parameters"]


def test_each_row_is_what_calibrate_says(fleet: Path, desk: Desk):
    shutil.copytree(fleet, desk.folder, dirs_exist_ok=True)
    desk.done("calibrate arm.toml 3-2025-03-01.csv --elastic 2,3 -o single")
    assert parameters(desk.folder / "single") == parameters(fleet / "out" / "S003" / "2025-03-01")
    there = {path.name for path in (fleet / "out" / "S003" / "2025-03-01").iterdir()}
    assert there == {"robot.toml", "result.json", "residuals.csv", "fleet.json"}
    desk.done("validate out/S003/2025-03-01/robot.toml 3-2025-03-01.csv")


def test_processes_change_nothing(fleet: Path, desk: Desk):
    shutil.copytree(fleet, desk.folder, dirs_exist_ok=True)
    desk.done("fleet fleet.csv -o again --jobs 2")
    for path in sorted((fleet / "out").rglob("result.json")):
        other = desk.folder / "again" / path.relative_to(fleet / "out")
        assert parameters(path.parent) == parameters(other.parent)


def test_what_is_done_is_not_done_again(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    before = times(tmp_path / "out")
    assert "11 of them from an earlier run" in " ".join(desk.done("fleet fleet.csv -o out").split())
    assert times(tmp_path / "out") == before
    (tmp_path / "out" / "S001" / "2025-03-01" / "notes.txt").write_text("mine")
    data = tmp_path / "1-2025-03-01.csv"
    data.write_text("\n".join(data.read_text().splitlines()[:-1]) + "\n")
    desk.done("fleet fleet.csv -o out")
    after = times(tmp_path / "out")
    assert {name for name in before if before[name] != after[name]} == {"S001/2025-03-01/result.json"}
    assert (tmp_path / "out" / "S001" / "2025-03-01" / "notes.txt").read_text() == "mine"
    assert [path.name for path in tmp_path.glob("out/S001/.*")] == []


def test_another_option_or_robot_is_done_again(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    before = times(tmp_path / "out")
    lines = (tmp_path / "fleet.csv").read_text().splitlines()
    lines[1] = lines[1].replace('"2,3"', "2;3:linear")
    (tmp_path / "fleet.csv").write_text("\n".join(lines))
    desk.done("fleet fleet.csv -o out")
    assert sum(before[name] != time for name, time in times(tmp_path / "out").items()) == 1
    robot = tmp_path / "arm.toml"
    robot.write_text(robot.read_text() + "\n")
    desk.done("fleet fleet.csv -o out")
    assert all(before[name] != time for name, time in times(tmp_path / "out").items())


def test_a_faulty_row_stops_no_other(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    shutil.rmtree(tmp_path / "out")
    (tmp_path / "5-2025-03-01.csv").write_text("q1 [deg],x\n1,2\n")
    lines = (tmp_path / "fleet.csv").read_text().splitlines()
    (tmp_path / "fleet.csv").write_text("\n".join([*lines, "S009,2025-03-01,arm.toml,0-2025-03-01.csv,9,,"]))
    ran = desk.run("fleet fleet.csv -o out --jobs 1")
    assert ran.status == 1
    words = " ".join(ran.out.split())
    assert "10 of 12 calibrations are done" in words
    assert "2 failed" in words
    assert "S005, 2025-03-01: failed: 5-2025-03-01.csv: expected the columns q1 … q6" in words
    assert "S009, 2025-03-01: failed: no element '9'" in words
    assert not (tmp_path / "out" / "S005").exists()
    assert len(times(tmp_path / "out")) == 10
    table = pl.read_parquet(tmp_path / "out" / "summary.parquet")
    assert table.filter(pl.col("status") == "failed")["serial"].to_list() == ["S005", "S009"]


def test_the_summary_tells_accuracy_siblings_compliance_and_drift(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    words = " ".join(desk.done("fleet fleet.csv -o out").split())
    assert "Fleet: 8 robots, 11 calibrations" in words
    assert "1 robot differs from siblings, 1 drifted." in words
    assert "example arm: compliance of 8 robots" in words
    found = json.loads(desk.done("fleet fleet.csv -o out --json"))
    assert {d["serial"] for d in found["siblings"][0]["deviations"]} == {"S002"}
    assert "3.theta.c" in {d["parameter"] for d in found["siblings"][0]["deviations"]}
    drifted = [row["serial"] for row in found["calibrations"] if row["drift"]]
    assert drifted == ["S002"]
    page = (tmp_path / "out" / "summary.html").read_text()
    assert all(f"S00{serial}" in page for serial in range(8))


def test_drift_is_that_of_diff(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    told = json.loads(desk.done("diff out/S002/2025-03-01 out/S002/2026-03-01 --json"))
    table = pl.read_parquet(fleet / "out" / "summary.parquet").filter(pl.col("drift_since").is_not_null())
    row = table.filter(pl.col("serial") == "S002").to_dicts()[0]
    assert row["drift_probability"] == told["probability"]
    assert row["drift_flange_rms"] == told["flange"]["rms"]
    scores = {p["name"]: p["score"] for p in told["parameters"]}
    changed = pl.read_parquet(fleet / "out" / "parameters.parquet").filter(
        (pl.col("serial") == "S002") & pl.col("change_score").is_not_null()
    )
    assert dict(zip(changed["parameter"], changed["change_score"], strict=True)) == scores


def test_a_toml_manifest_says_the_same(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    (tmp_path / "fleet.toml").write_text(
        'format = "elastocal-fleet/1"\n[defaults]\nrobot = "arm.toml"\nelastic = ["2", "3"]\n'
        '[[calibration]]\nserial = "S003"\ndate = 2025-03-01\ndata = ["3-2025-03-01.csv"]\n'
        '[[calibration]]\nserial = "both"\ndate = 2025-03-01\ndata = "1-2025-03-01.csv;1-2026-03-01.csv"\n'
        "holdout = 0.3\nseed = 4\n"
    )
    desk.done("fleet fleet.toml -o toml --jobs 1")
    assert parameters(tmp_path / "toml" / "S003" / "2025-03-01") == parameters(fleet / "out" / "S003" / "2025-03-01")
    both = json.loads((tmp_path / "toml" / "both" / "2025-03-01" / "result.json").read_text())
    assert both["residuals"]["held_out"]["n"] == 27
    assert both["settings"]["seed"] == 4


FAULTS = """\
serial,date,robot,data,held_out,holdout,loss,elastic,bootstrap,prior
A,2025-03-01,arm.toml,0-2025-03-01.csv,,,,,,
A,2025-03-01,arm.toml,0-2025-03-01.csv,,,,,,
B,yesterday,arm.toml,missing.csv,,1.5,hubr,"2,2",some,perhaps
C/D,2025-03-01,arm.tml,0-2025-03-01.csv,1-2025-03-01.csv,0.3,,,,
,2025-03-01,arm.toml,0-2025-03-01.csv,0-2025-03-01.csv,,,,,
E,2025-03-01,arm.toml,0-2025-03-01.csv,,,,,,,surplus
"""


def test_all_faults_of_a_manifest_are_told_and_nothing_is_written(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    (tmp_path / "bad.csv").write_text(FAULTS)
    told = "\n".join(desk.refused("fleet bad.csv -o new"))
    for expected in (
        "bad.csv: row 2: serial A and date 2025-03-01 are in row 1 already",
        "bad.csv: row 3 (B): data: missing.csv: no such file",
        "row 3 (B): date: expected a date as 2026-03-31 (or 2026-03-31T14:30), found 'yesterday'",
        "row 3 (B): holdout: expected a fraction between 0 and 1, as 0.3, found 1.5",
        "row 3 (B): loss: no loss 'hubr'; did you mean 'huber'?",
        "row 3 (B): elastic 2,2: element '2' is named twice",
        "row 3 (B): bootstrap: expected a whole number, 0 or more, found 'some'",
        "row 3 (B): prior: expected true or false, found 'perhaps'",
        "row 4 (C/D): serial: its folder gets this name",
        "row 4 (C/D): robot: arm.tml: no such file",
        "row 4 (C/D): held-out rows are given and asked for (held_out and holdout)",
        "row 5: 'serial' is missing",
        "row 5: 0-2025-03-01.csv is both fitted and held out: choose one",
        "row 6: expected 10 cells, as in the header, found 11",
    ):
        assert expected in told
    (tmp_path / "bad.csv").write_text("serial,robot,data,elestic\nA,arm.toml,0-2025-03-01.csv,2\n")
    assert desk.refused("fleet bad.csv -o new") == [
        f"bad.csv: no column 'elestic'; did you mean 'elastic'? (valid: serial, date, robot, data, held_out, tip, "
        f"{', '.join(OPTIONS)})",
        "bad.csv: expected a column 'date', found none",
    ]
    (tmp_path / "bad.csv").write_text("serial,date,robot,data\n")
    assert desk.refused("fleet bad.csv -o new") == ["bad.csv: expected one calibration or more, found none"]
    assert desk.refused("fleet bad.txt -o new")[0].startswith("bad.txt: no such file")


def test_faults_of_a_toml_manifest(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    (tmp_path / "bad.toml").write_text(
        'format = "elastocal-fleet/2"\nextra = 1\n[[calibration]]\nserial = "A"\nholdot = 0.3\ndata = { a = 1 }\n'
    )
    told = "\n".join(desk.refused("fleet bad.toml -o new"))
    for expected in (
        "format: expected 'elastocal-fleet/1', found 'elastocal-fleet/2'",
        "no key 'extra'",
        "row 1: no key 'holdot'; did you mean 'holdout'?",
        "row 1, data: expected text, a number, true or false, or a list of texts",
        "row 1 (A): 'date' is missing",
    ):
        assert expected in told


def test_a_descriptor_whose_file_is_missing_is_a_fault_of_the_manifest(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    (tmp_path / "d.toml").write_text('format = "elastocal-measurements/1"\nfile = "gone.csv"\n[columns]\n')
    (tmp_path / "m.csv").write_text("serial,date,robot,data\nA,2025-03-01,arm.toml,d.toml\n")
    assert desk.refused("fleet m.csv -o new")[0].startswith("m.csv: row 1 (A): data: gone.csv: no such file")


def test_places_that_are_not_a_fleets_are_left_alone(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    (tmp_path / "new" / "S003" / "2025-03-01").mkdir(parents=True)
    told = desk.refused("fleet fleet.csv -o new")
    assert told == ["new/S003/2025-03-01 is there, but is no result of a fleet: choose another folder (-o DIR)"]
    (tmp_path / "m.csv").write_text(
        "serial,date,robot,data\nS001,2025-03-01,out/S001/2025-03-01/robot.toml,0-2025-03-01.csv\n"
    )
    assert desk.refused("fleet m.csv -o out") == [
        "out/S001/2025-03-01/robot.toml is an input, and lies where results go: choose another folder (-o DIR)"
    ]


def test_an_unreachable_scheduler_is_said_soon_and_nothing_is_written(fleet: Path, tmp_path: Path):
    desk = copied(fleet, tmp_path)
    told = desk.refused("fleet fleet.csv -o new --scheduler tcp://127.0.0.1:9")
    assert "scheduler tcp://127.0.0.1:9: none answers there within 5 s" in told[0]
    assert "expected an address as tcp://HOST:PORT" in desk.refused("fleet fleet.csv -o new --scheduler nowhere:x:y")[0]
    told = desk.refused("fleet fleet.csv -o new --jobs 2 --scheduler tcp://127.0.0.1:9")
    assert told == ["--jobs is of local processes, --scheduler of a cluster: give one of the two"]


def test_alike_robots_are_accused_as_seldom_as_promised():
    rng, robots, parameters, accused = np.random.default_rng(5), 12, 20, 0
    limit = threshold(robots, parameters)
    for _ in range(1000):
        stds = rng.uniform(0.1, 0.5, (robots, parameters))
        values = rng.standard_normal((robots, parameters)) + stds * rng.standard_normal((robots, parameters))
        accused += bool((np.abs(robust_scores(values, stds)[2]) > limit).any())
    assert accused <= 1000 * LEVEL + 3.0 * np.sqrt(1000 * LEVEL)


def test_the_threshold_is_what_it_says_without_noise():
    rng, robots, parameters = np.random.default_rng(6), 8, 10
    values = rng.standard_normal((4000, robots, parameters))
    limit = threshold(robots, parameters)
    accused = sum(bool((np.abs(robust_scores(one, np.zeros_like(one))[2]) > limit).any()) for one in values)
    assert accused / 4000 == pytest.approx(LEVEL, abs=0.015)
    assert threshold(8, 10) > threshold(30, 10) > threshold(30, 1)


def test_few_siblings_are_not_judged(fleet: Path):
    result: SavedResult = ec.load_result(fleet / "out" / "S001" / "2025-03-01")
    odd = replace(result, parameters=tuple(replace(p, identified=9.0) for p in result.parameters))
    assert siblings_of(["a", "b", "c", "d"], [result, result, result, odd]).deviations == ()
    found = siblings_of(list("abcdefgh"), [result] * 7 + [odd])
    assert {deviation.serial for deviation in found.deviations} == {"h"}
    assert not any(name.startswith(("base", "tool")) for name in found.parameters)


def test_manifest_options_are_those_of_calibrate(tmp_path: Path):
    (tmp_path / "r.toml").write_text("")
    (tmp_path / "d.csv").write_text("")
    (tmp_path / "m.csv").write_text(
        "serial,date,robot,data,identify,fix,elastic,transition,non_negative,transmission,tip\n"
        "A,2025-03-01T08:30,r.toml,d.csv,*.theta;2.*,2.a,2:step;3,80;120,yes,auto,tool0\n"
    )
    row = read_manifest(tmp_path / "m.csv")[0]
    assert row.options == {
        "identify": ["*.theta", "2.*"],
        "fix": ["2.a"],
        "elastic": {"2": "step", "3": "linear"},
        "transition": [80.0, 120.0],
        "non_negative": True,
        "transmission": "auto",
    }
    assert (row.tip, str(row.folder)) == ("tool0", "A/2025-03-01T0830")


def test_run_fleet_is_the_command(fleet: Path, tmp_path: Path):
    summary = ec.run_fleet(fleet / "fleet.csv", tmp_path / "api")
    assert len(summary.outcomes) == 11
    assert summary.failed == ()
    names = {name.partition("/")[0] for name in contents(tmp_path / "api")}
    assert names >= {"S000", "S007", "summary.parquet", "parameters.parquet"}
