"""Studies: a grid of simulated calibrations whose results go on from where they were."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import elastocal as ec
from elastocal.comparison import MODELS
from elastocal.errors import WorkerLostError
from elastocal.io.study_files import READERS, read_study, words
from elastocal.io.study_parts import SCHEMA
from elastocal.io.study_values import MEASURES, Setting
from elastocal.studies.item import MEASURED, Calibrations, Lot, simulated
from elastocal.studies.run import _lost
from elastocal.studies.simulation import planned_poses
from elastocal.studies.summary import Share
from support.files import Desk, contents, desk, edited

__all__ = ["desk"]

STUDY = """\
format = "elastocal-study/1"
name = "small"
repeats = 4
seed = 2
held_out = 50
measures = ["coverage"]

[actual]
geometry_error = "0.5mm,0.5mrad"

[actual.elastic.2]
compliance = [1e-6, 3e-6]
stiffening = 2.5
transition_torque = [200, 300]
largest_load = 600

[setting]
noise = "0.03mm"

[grid]
poses = [30, 60]
law = ["rigid", "linear"]
"""


def table(folder: Path) -> pl.DataFrame:
    """All results, but for the time that they took."""
    return pl.scan_parquet(folder / "parts" / "*.parquet").sort("cell", "repeat").collect().drop("seconds")


def test_results_are_a_table_that_can_be_queried(desk: Desk):
    desk.write(study_toml=STUDY)
    printed = desk.done("study study.toml -o out --jobs 1")
    found = table(desk.folder / "out")
    assert found.columns == [name for name in SCHEMA if name != "seconds"]
    assert len(found) == 16
    assert set(found["status"]) == {"converged"}
    assert found.group_by("poses", "law").len()["len"].to_list() == [4] * 4
    means = found.filter(law="linear").group_by("poses").agg(pl.col("held_out_mean").mean()).sort("poses")
    assert means["held_out_mean"][0] > means["held_out_mean"][1]
    assert (found["held_out_mean"] < 0.2 * found["nominal_mean"]).all()
    assert (found["name"].list.len() == found["identified"].list.len()).all()
    assert (found["covered"].list.len() == found["interval_name"].list.len()).all()
    shown = [line.split() for line in printed.splitlines() if line.split()[:2] == ["30", "linear"]]
    assert shown[0][2] == "4/4"
    assert float(shown[0][4]) == pytest.approx(1e3 * means["held_out_mean"][0], abs=1e-4)
    summary = pl.read_parquet(desk.folder / "out" / "summary.parquet")
    assert summary.filter(law="linear")["held_out_mean"].to_list() == pytest.approx(means["held_out_mean"].to_list())
    assert "Held-out error" in (desk.folder / "out" / "summary.html").read_text()


def test_more_repeats_and_points_go_on_with_what_is_there(desk: Desk):
    desk.write(study_toml=STUDY)
    desk.done("study study.toml -o out --jobs 1")
    before = {p: p.stat().st_mtime_ns for p in (desk.folder / "out" / "parts").iterdir()}
    desk.done("study study.toml -o out --jobs 1")
    assert {p: p.stat().st_mtime_ns for p in (desk.folder / "out" / "parts").iterdir()} == before
    desk.write(study_toml=edited(STUDY, ("repeats = 4", "repeats = 6"), ("[30, 60]", "[60, 30, 45]")))
    desk.done("study study.toml -o out --jobs 1")
    assert {p: p.stat().st_mtime_ns for p in before} == before
    desk.done("study study.toml -o whole --jobs 2")
    grown = table(desk.folder / "out")
    assert len(grown) == 36
    assert grown.equals(table(desk.folder / "whole"))
    desk.write(study_toml=edited(STUDY, ("repeats = 4", "repeats = 2")))
    told = json.loads(desk.done("study study.toml -o out --json"))
    assert told["calibrations"] == 8


def test_another_study_needs_another_folder(desk: Desk):
    desk.write(study_toml=edited(STUDY, ("repeats = 4", "repeats = 1"), ("[30, 60]", "[30]")))
    desk.done("study study.toml -o out --jobs 1")
    desk.write(study_toml=edited(STUDY, ("seed = 2", "seed = 3")))
    assert desk.refused("study study.toml -o out") == [
        "out holds the results of another study (seed differs): choose another folder (-o DIR); a study goes on only "
        "with more repeats or another grid"
    ]


FAULTS = {
    "no grid": (
        ('[grid]\nposes = [30, 60]\nlaw = ["rigid", "linear"]\n', ""),
        "'grid' is missing: expected what is varied, as poses = [20, 40, 60]",
    ),
    "an empty grid": (
        ('poses = [30, 60]\nlaw = ["rigid", "linear"]\n', ""),
        "grid: expected what is varied, as poses = [20, 40, 60]",
    ),
    "a value alone": (
        ("poses = [30, 60]", "poses = 30"),
        "grid.poses: expected one value or more in brackets, found 30",
    ),
    "an unknown key": (("name = ", "nane = "), "no key 'nane'; did you mean 'name'?"),
    "an unknown part of a setting": (("noise = ", "nose = "), "setting: no key 'nose'; did you mean 'noise'?"),
    "an unknown part of a grid": (("poses = ", "pose = "), "grid: no key 'pose'; did you mean 'poses'?"),
    "a noise that is none": (("0.03mm", "0.03 deg"), "setting.noise: no length unit 'deg'"),
    "no poses": (("[30, 60]", "[30, 0]"), "grid.poses: expected a whole number, 1 or more, found 0"),
    "an unknown law": (('"linear"]', '"linar"]'), "grid.law: no choice 'linar'; did you mean 'linear'?"),
    "no repeats": (("repeats = 4", "repeats = 0"), "repeats: expected a whole number, 1 or more, found 0"),
    "an unknown measure": (('["coverage"]', '["cover"]'), "measures: no measure 'cover'; did you mean 'coverage'?"),
    "a value twice": (("[30, 60]", "[30, 30]"), "grid.poses: a value is there twice"),
    "a key in both": (("noise = ", "poses = 3\nnoise = "), "poses is both in [setting] and in [grid]: choose one"),
    "an element that is not there": (("elastic.2]", "elastic.9]"), "actual.elastic: no element '9'"),
    "no transition torque": (
        ("transition_torque = [200, 300]\n", "", '"linear"]', '"hinge"]'),
        "actual.elastic.2: 'transition_torque' is missing: the law hinge needs it",
    ),
    "no payload": (('noise = "0.03mm"', 'payload = "heavy"'), "payload: example arm has no load 'heavy'"),
    "another robot": (('name = "small"', 'robot = "arm.toml"'), "robot: arm.toml: no such file"),
    "an error without angle": (("0.5mm,0.5mrad", "0.5mm"), "actual.geometry_error: expected a length and an angle"),
    "torques that are not searched": (
        ('["coverage"]', '["transition"]'),
        "measures transition: the model rigid has no transition torque",
    ),
    "another kind of file": (("elastocal-study/1", "elastocal-robot/1"), 'found "elastocal-robot/1": a robot file'),
}


@pytest.mark.parametrize("case", FAULTS)
def test_faults_of_a_study_are_named_and_nothing_is_written(desk: Desk, case: str):
    edits, expected = FAULTS[case]
    desk.write(study_toml=edited(STUDY, *zip(edits[::2], edits[1::2], strict=True)))
    told = desk.refused("study study.toml -o out")
    assert all(line.startswith("study.toml: ") for line in told)
    assert expected in "\n".join(told)


def test_all_faults_are_told_together(desk: Desk):
    text = edited(STUDY, ("0.03mm", "much"), ("[30, 60]", "[-1]"), ('["coverage"]', '["cover"]'))
    desk.write(study_toml=text)
    assert len(desk.refused("study study.toml -o out")) == 3
    assert desk.refused("study none.toml -o out")[0].startswith("none.toml: no such file")


def test_an_unreachable_scheduler_is_said_and_nothing_is_written(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    desk.write(study_toml=STUDY)
    monkeypatch.setenv("ELASTOCAL_SCHEDULER", "tcp://127.0.0.1:9")
    assert "scheduler tcp://127.0.0.1:9: none answers there within 5 s" in desk.refused("study study.toml -o out")[0]


def study_of(folder: Path, *edits: tuple[str, str]) -> object:
    (folder / "s.toml").write_text(edited(STUDY, *edits))
    return read_study(folder / "s.toml")


def test_points_of_the_grid_share_robots_poses_and_noise(tmp_path: Path):
    study = study_of(tmp_path)
    few, many = (simulated(study, Lot(setting, (1,)), 1, 1.4) for setting in study.settings if setting.law == "linear")
    assert few.actual == many.actual
    assert np.array_equal(few.data.q, many.data.q[:30])
    assert np.array_equal(few.held_out.q, many.held_out.q)
    other = simulated(study, Lot(study.settings[0], (2,)), 2, 1.4)
    assert other.actual.rows != few.actual.rows


def test_outliers_are_added_to_the_same_readings_and_known(tmp_path: Path):
    study = study_of(tmp_path, ('noise = "0.03mm"', 'noise = "0.03mm"\noutliers = 0.1\noutlier_size = "20mm"'))
    made = simulated(study, Lot(study.settings[0], (0,)), 0, 1.4)
    assert len(made.wrong) == 3
    row = Calibrations.of(study)(Lot(study.settings[0], (0,)))[0]
    assert row["status"] == "converged"


def test_a_grid_of_everything_else(desk: Desk):
    grid = (
        'poses = [40]\nlaw = ["step", "hinge"]\ntransition = ["exact", "true"]\noutliers = [0.0, 0.1]\n'
        'loss = ["cauchy"]\nselection = ["random"]\n'
    )
    text = STUDY[: STUDY.index("poses = [30")] + grid
    desk.write(study_toml=edited(text, ("repeats = 4", "repeats = 1"), ('"coverage"', '"transition", "outliers"')))
    printed = desk.done("study study.toml -o out --jobs 1")
    found = table(desk.folder / "out").sort("law", "outliers", "transition")
    true = found.filter(transition="true")
    assert true["torque_error"].list.eval(pl.element().abs().max()).explode().max() < 1e-9
    assert found.filter(transition="exact")["torque_score"].explode().is_finite().all()
    assert found.filter(outliers=0.1)["outliers_wrong"].to_list() == [4] * 4
    assert found.filter(outliers=0.1)["outliers_named"].sum() >= 15
    assert "Transition torques" in printed
    assert "outliers named" in printed
    assert max(map(len, printed.splitlines())) <= 80


def test_the_right_law_is_counted(desk: Desk):
    text = STUDY[: STUDY.index("poses = [30")] + 'law = ["rigid", "cubic"]\nidentify = ["", "*.theta;2.*"]\n'
    desk.write(study_toml=edited(text, ("repeats = 4", "repeats = 1"), ('"coverage"', '"recommendation"')))
    desk.done("study study.toml -o out --jobs 1")
    found = table(desk.folder / "out")
    assert set(found["compared"].explode()) == set(MODELS)
    for row in found.to_dicts():
        best = dict(zip(row["compared"], row["criterion"], strict=True))
        assert row["recommended"] == min(best, key=lambda name: best[name])
        assert row["right"] == (row["recommended"] == row["law"])
    assert found.filter(identify="*.theta;2.*")["parameters"].max() < found.filter(identify="")["parameters"].min()


def test_planned_poses_tell_more_than_random_ones(tmp_path: Path):
    study = study_of(tmp_path, ("poses = [30, 60]", "poses = [25]"), ('["rigid", "linear"]', '["linear"]'))
    setting = study.settings[0]
    planned = tuple(planned_poses(study, setting))
    assert sum(len(part.q) for part in planned) == 25
    work = Calibrations.of(study)
    random, chosen = (
        np.mean([row["held_out_mean"] for row in work(lot)])
        for lot in (Lot(setting, (0, 1, 2, 3)), Lot(setting, (0, 1, 2, 3), planned))
    )
    assert chosen < random


def test_payloads_share_the_poses(tmp_path: Path):
    robot = Path(ec.__file__).parent / "examples" / "arm.toml"
    (tmp_path / "arm.toml").write_text(robot.read_text() + "\n[load.heavy]\nmass = 20.0\ncom = [0.0, 0.0, 100.0]\n")
    study = study_of(
        tmp_path, ('name = "small"', 'robot = "arm.toml"'), ('noise = "0.03mm"', 'payload = ["none", "heavy"]')
    )
    made = simulated(study, Lot(study.settings[0], (0,)), 0, 1.4)
    names = [made.data.load.name(int(code)) for code in made.data.load.codes]
    assert (names.count(None), names.count("heavy")) == (15, 15)


def test_what_goes_wrong_in_one_calibration_stops_no_other(tmp_path: Path):
    study = study_of(tmp_path, ("[1e-6, 3e-6]", "[1.0, 3.0]"), ("[30, 60]", "[30]"))
    rows = Calibrations.of(study)(Lot(study.settings[1], (0, 1)))
    assert [row["status"] for row in rows] == ["failed", "failed"]
    assert "does not settle under its load" in rows[0]["reason"]
    lost = _lost(Lot(study.settings[1], (4, 5)), WorkerLostError("killed"))
    assert [(row["repeat"], row["reason"]) for row in lost] == [(4, "killed"), (5, "killed")]
    summary = ec.run_study(study, tmp_path / "out")
    assert [cell.sound for cell in summary.cells] == [4, 0]
    assert "out/study.json" in {f"out/{name}" for name in contents(tmp_path / "out")}


def test_every_part_of_a_setting_can_be_read_shown_and_stored():
    names = {one.name for one in fields(Setting)}
    assert names == set(READERS)
    assert names <= set(SCHEMA)
    assert len(words(Setting(), tuple(names))) == len(names)
    assert set(MEASURES) == set(MEASURED)


def test_intervals_of_shares():
    low, high = Share(19, 20).interval
    assert (low, high) == pytest.approx((0.764, 0.991), abs=1e-3)  # Wilson, by hand
    assert Share(0, 0).interval == (0.0, 1.0)


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[1] / "studies").glob("*.toml")), ids=lambda p: p.stem)
def test_the_projects_studies_can_be_read(path: Path):
    study = read_study(path)
    assert study.repeats >= 20
    assert len(study.settings) > 1
