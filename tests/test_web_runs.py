"""Runs of the page: files in, what is wrong with them, settings, the command that does the same, results out."""

from __future__ import annotations

import io
import json
import re
import socket
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.cli.main import main
from elastocal.errors import InputError
from elastocal.robot import Robot, Row
from elastocal.web.preview import preview
from elastocal.web.routes.running import curve
from elastocal.web.runs import Record, Run, Runs, State
from elastocal.web.server import claimed
from elastocal.web.settings import settings_json, settings_of
from elastocal.web.study import study
from support.files import DESCRIPTOR, ROBOT, TABLE, TRACKER, URDF, Desk, desk, edited
from support.robots import arm, placed
from support.web import SETTINGS, Page, client_of, files, page, wait_for, words

__all__ = ["desk", "files", "page"]

BRANCHED = edited(
    URDF,
    ('<link name="l2"/>', '<link name="l2"/><link name="camera"/>'),
    (
        "</robot>",
        '<joint name="j3" type="fixed"><parent link="l1"/><child link="camera"/></joint></robot>',
    ),
)


LONG = {"law 2": "step", "transition": "ga", "population": "4", "generations": "100000"}
"""Settings of a run that takes hours."""


def test_all_faults_of_all_files_are_listed_with_their_places(page: Page):
    table = edited(TABLE, ("100,200,300", "abc,200,300"), ("12,22", "400,22"))
    run = page.new({"robot.toml": ROBOT, "fit.csv": table, "more.csv": "q1,q2\n1,2\n"})
    text = words(page.text(run))
    assert "<b>row 1, column 'x [mm]'</b> expected a number, found 'abc'" in text
    assert "<b>row 3, column 'q1 [deg]'</b> expected joint 1 within its limits" in text
    assert "expected something measured" in text
    assert str(page.folder) not in text
    page.upload(run, "fit.csv", TABLE)
    page.do(f"{run}/remove", file="more.csv")
    assert "faults" not in page.text(run)


def test_a_file_that_is_no_robot_or_no_table_says_so(page: Page):
    run = page.new({"robot.toml": "x = 1", "fit.xlsx": "", "notes.pdf": b"%PDF"})
    assert "format" in words(page.text(run))
    run = page.new({"robot.toml": ROBOT, "fit.xlsx": ""})
    assert "save the sheet as CSV" in words(page.text(run))
    assert "Still missing: a robot file" in page.text(page.new({"fit.csv": TABLE}))
    assert "Still missing: measurements" in page.text(page.new({"robot.toml": ROBOT}))


def test_data_that_do_not_belong_to_the_robot_are_told(page: Page, files: dict[str, bytes]):
    swapped = files["fit.csv"].replace(b"x [mm],y [mm]", b"y [mm],x [mm]")
    text = words(page.text(page.new({"robot.toml": files["robot.toml"], "fit.csv": swapped})))
    assert "Robot and measurements together" in text
    assert "mirrored" in text


def test_files_get_the_roles_that_suit_and_others_if_asked(page: Page, files: dict[str, bytes]):
    run = page.new(files)
    assert "40 held-out rows" in words(page.text(run)).replace("<b>", "")
    page.do(f"{run}/roles", **{"role held_out.csv": "fit"})
    text = words(page.text(run))
    assert "from 80 rows" in text
    assert 'name="holdout"' in text
    page.do(f"{run}/roles", **{"role held_out.csv": "unused"})
    assert "from 40 rows" in words(page.text(run))


def test_the_latest_robot_counts(page: Page, files: dict[str, bytes]):
    run = page.new(files)
    other = files["robot.toml"].replace(b'name = "arm"', b'name = "arm, corrected"')
    page.upload(run, "another.toml", other)
    assert "another.toml fit.csv" in words(page.text(run))
    page.do(f"{run}/roles", **{"role robot.toml": "robot", "role another.toml": "unused"})
    assert "robot.toml fit.csv" in words(page.text(run))


def test_a_descriptor_reads_the_file_given_with_it(page: Page):
    text = words(page.text(page.new({"robot.toml": ROBOT, "t.toml": DESCRIPTOR, "tracker.csv": TRACKER})))
    assert "2 rows of position and orientation" in text
    assert "Read by its descriptor" in text


def test_a_urdf_that_branches_asks_for_its_tip(page: Page):
    run = page.new({"robot.urdf": BRANCHED, "fit.csv": TABLE})
    text = page.text(run)
    assert "the chain branches" in text
    assert "<option>l2</option><option>camera</option>" in text
    page.do(f"{run}/roles", tip="l2")
    text = words(page.text(run))
    assert "--tip l2" in text
    assert "faults" not in text


def test_without_masses_nothing_can_be_elastic(page: Page, files: dict[str, bytes]):
    light = re.sub(rb"(?m)^mass = .*$", b"mass = 0.0", files["robot.toml"])
    text = words(page.text(page.new({"robot.toml": light, "fit.csv": files["fit.csv"]})))
    assert "Nothing loads the joints" in text
    assert "--elastic" not in text


def test_joints_that_show_their_compliance_are_suggested():
    robot = arm()
    found = {joint.name: joint for joint in study(robot, _measured(robot)).joints}
    assert not found["1"].worth
    assert "vertical" in found["1"].why
    assert found["2"].worth
    assert found["3"].worth
    assert found["2"].effect > found["3"].effect > found["5"].effect


def _measured(robot: Robot, count: int = 30) -> ec.Measurements:
    actual = placed(robot, np.random.default_rng(0))
    return ec.simulate(actual, ec.random_poses(actual, count, 1), seed=2)


def test_the_preview_draws_the_robot_to_the_measured_points():
    robot = arm()
    data = _measured(robot)
    found = study(robot, data)
    drawn = preview(found.aligned, data, found.errors)
    ends = np.array([line[-3:] for line in drawn["poses"]])
    assert np.abs(ends - np.array(drawn["points"])).max() <= 2  # 0.1 mm each
    assert max(drawn["errors"]) < 1e-3
    assert np.array(drawn["poses"])[:, :3].any() == 0
    assert drawn["joints"][0] <= 1
    assert np.allclose(np.array(drawn["q"]) * np.pi / 180.0, data.q, atol=1e-4)


def test_the_preview_is_there_for_prismatic_joints_and_distances():
    row = Row("track", "prismatic", {}, limits=(-1.0, 1.0), mass=5.0)
    turned = replace(arm().rows[0], geometry={**arm().rows[0].geometry, "alpha": 1.2})
    robot = replace(arm(), rows=(row, turned, *arm().rows[1:]))
    actual = placed(robot, np.random.default_rng(0))
    data = ec.simulate(actual, ec.random_poses(actual, 20, 1), kinds=("distance",))
    drawn = preview(actual, data, None)
    assert drawn["points"] == [None] * 20
    assert np.allclose(np.array(drawn["q"])[:, 0], 1e3 * data.q[:, 0], atol=1e-2)


def test_settings_are_kept(page: Page, files: dict[str, bytes]):
    run = page.new(files)
    page.client.post(f"{run}/settings", data=SETTINGS | {"law 2": "step", "law 3": "rigid", "seed": "7", "name": "May"})
    text = page.text(run)
    assert 'value="7"' in text
    assert "May" in text
    assert "--elastic 2:step" in words(text)
    kept = Run(page.run_folder(run)).settings
    assert settings_of(json.loads(settings_json(kept))) == kept
    assert settings_of({"unknown": 1, "seed": 2}).seed == 2


def test_a_run_from_files_to_a_robot_that_can_be_used(page: Page, files: dict[str, bytes], tmp_path: Path):
    run = page.new(files)
    assert page.do(f"{run}/start", **SETTINGS, **{"law 2": "linear", "law 3": "linear"}) == run
    assert "Calibrating" in page.text(run)
    text = page.finished(run)
    assert "Done" in text
    assert "calibrated, held-out" in text
    robot = page.client.get(f"{run}/download/robot.toml")
    assert "attachment" in robot.headers["content-disposition"]
    (tmp_path / "robot.toml").write_bytes(robot.content)
    found = ec.load_robot(tmp_path / "robot.toml")
    assert found.elastic["2.theta"].coefficients[0] == pytest.approx(2e-6, rel=0.1)
    archive = zipfile.ZipFile(io.BytesIO(page.client.get(f"{run}/download/result.zip").content))
    assert {"robot.toml", "result.json", "residuals.csv"} <= set(archive.namelist())
    report = page.client.get(f"{run}/report")
    assert "sandbox" in report.headers["content-security-policy"]
    home = words(page.text("/"))
    assert "mean, held-out" in home
    # a result is not changed any more, but copied
    assert page.client.post(f"{run}/start").status_code == 409
    assert page.upload(run, "fit.csv", TABLE).status_code == 409
    copy = page.do(f"{run}/copy")
    assert "Draft" in page.text(copy)
    assert "--elastic 2,3" in words(page.text(copy))


def test_two_runs_at_a_time_do_not_disturb_each_other(page: Page, files: dict[str, bytes], tmp_path: Path):
    """What each finds is what it finds alone."""
    rigid = {f"law {joint}": "rigid" for joint in range(1, 7)}
    laws = (rigid | {"law 2": "linear", "law 3": "linear"}, rigid)
    runs = [page.new(files) for _ in laws]
    for run, chosen in zip(runs, laws, strict=True):
        page.do(f"{run}/start", **SETTINGS, **chosen)
    for run in runs:
        page.finished(run)
    for run, elastic in zip(runs, (["--elastic", "2,3"], []), strict=True):
        folder = page.run_folder(run)
        inputs = [str(folder / "inputs" / name) for name in ("robot.toml", "fit.csv")]
        held_out = ["--held-out", str(folder / "inputs" / "held_out.csv")]
        assert main(["calibrate", *inputs, *held_out, *elastic, "-o", str(tmp_path / folder.name), "--json"]) == 0
        alone, beside = (
            json.loads((at / "result.json").read_text(encoding="utf-8"))["residuals"]
            for at in (tmp_path / folder.name, folder / "result")
        )
        assert alone == beside
    text = words(page.text(f"/compare?run={runs[0].rpartition('/')[2]}&run={runs[1].rpartition('/')[2]}"))
    assert "2 runs compared" in text
    assert "2.theta.c" in text
    assert "different laws of compliance" in text


def test_a_failed_verdict_and_a_bad_input_are_told_in_words(page: Page, files: dict[str, bytes]):
    few = b"\n".join(files["fit.csv"].splitlines()[:6]) + b"\n"
    run = page.new({"robot.toml": files["robot.toml"], "fit.csv": few})
    page.do(f"{run}/start", **SETTINGS, **{"law 2": "linear"})
    text = words(page.finished(run))
    assert "No verdict" in text
    # the settings pass the page, but not the command: a transition torque too many
    run = page.new(files)
    form = {"law 2": "step", "law 3": "linear", "transition": "given", "torques": "150,60"}
    page.do(f"{run}/start", **(SETTINGS | form))
    text = words(page.finished(run))
    assert "Bad input" in text
    assert "elastocal: " in text
    assert "Traceback" not in text


def test_a_long_run_is_stopped_and_leaves_nothing_half(page: Page, files: dict[str, bytes]):
    run = page.new(files)
    page.do(f"{run}/start", **(SETTINGS | LONG))
    wait_for(lambda: " of 100000</b> done" in page.client.get(f"{run}/progress").text)
    assert page.client.post(f"{run}/delete").status_code == 409
    page.do(f"{run}/stop")
    text = page.text(run)
    assert "Stopped" in text
    assert "Calibrate</button>" in text
    assert not (page.run_folder(run) / "result").exists()
    assert page.do(f"{run}/delete") == "/"
    assert not page.run_folder(run).exists()


def test_a_run_that_a_restart_interrupts_can_be_run_again(tmp_path: Path, files: dict[str, bytes]):
    with client_of(tmp_path) as client:
        page = Page(tmp_path, client)
        run = page.new(files)
        page.do(f"{run}/start", **(SETTINGS | LONG))
        wait_for(lambda: " of 100000</b> done" in client.get(f"{run}/progress").text)
    with client_of(tmp_path) as client:
        page = Page(tmp_path, client)
        assert "Interrupted" in page.text("/")
        assert "Interrupted" in page.text(run)
        page.do(f"{run}/start", **SETTINGS)
        assert "Done" in page.finished(run)


def test_progress_can_be_told_to_another_program(desk: Desk, files: dict[str, bytes], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ELASTOCAL_PROGRESS", "json")
    desk.write(robot_toml=files["robot.toml"], fit_csv=files["fit.csv"])
    search = "--elastic 2:step --transition ga --population 4 --generations 2"
    told = [
        json.loads(line)["progress"] for line in desk.run(f"calibrate robot.toml fit.csv {search}").err.splitlines()
    ]
    assert {"done": 2, "total": 2} in told
    told = [json.loads(line)["progress"] for line in desk.run("calibrate robot.toml fit.csv").err.splitlines()]
    assert told[0].keys() == {"step", "misfit"}
    assert told[0]["step"] == 1


def test_the_curve_of_the_misfit_goes_from_top_to_bottom():
    assert curve((3.0,)) == ""
    assert curve((5.0, 1.0, 3.0)) == "0.0,4.0 300.0,76.0 600.0,40.0"
    assert curve((2.0, 2.0)) == "0.0,4.0 600.0,4.0"


def test_a_port_or_a_folder_that_another_has_is_refused(desk: Desk):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = desk.refused(f"serve runs --port {port} --no-browser")
        assert said[-1] == f"--port {port}: address already in use: choose another, as --port {port + 1}"
    here, there = claimed(desk.folder / "runs"), claimed(desk.folder / "runs")
    with here, pytest.raises(InputError, match="another elastocal serve has this folder"), there:
        pass
    desk.write(file_txt="")
    with pytest.raises(InputError, match="cannot be written to"), claimed(desk.folder / "file.txt"):
        pass


@pytest.mark.parametrize(
    ("record", "at_work", "state"),
    [
        (None, False, State.DRAFT),
        (Record("t"), True, State.RUNNING),
        (Record("t"), False, State.INTERRUPTED),
        (Record("t", "t", 0), False, State.DONE),
        (Record("t", "t", 1), False, State.FAILED),
        (Record("t", "t", 2), False, State.REFUSED),
        (Record("t", "t", -15, True), False, State.STOPPED),
        (Record("t", "t", -9), False, State.CRASHED),
    ],
)
def test_states_follow_from_files(tmp_path: Path, record: Record | None, at_work: bool, state: State):
    run = Runs(tmp_path).create()
    if record is not None:
        run.save_record(record)
    assert Runs(tmp_path).all()[0].state(at_work) == state


def test_damaged_folders_are_no_runs_or_drafts(page: Page):
    run = page.new({"robot.toml": ROBOT})
    folder = page.run_folder(run)
    (folder / "record.json").write_text("{")
    assert "Draft" in page.text(run)
    (page.folder / "20260101-000000-abcdef").mkdir()
    (page.folder / "notes-of-mine-x").write_text("")
    assert page.text("/").count('class="card"') == 1
    assert [one.id for one in Runs(page.folder).all()] == [folder.name]
