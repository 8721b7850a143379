"""The benchmark against the peers: its arms, its runs and its page. The tools themselves are not run here."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import elastocal as ec
from elastocal.examples import ROBOT_FILE
from elastocal.robot import Compliance, Frame
from elastocal.simulation import random_poses

PEERS = Path(__file__).parents[1] / "benchmarks" / "peers"
sys.path.insert(0, str(PEERS))
try:
    import arms
    import run
    import runs
    import tools
    from environments import Environment
    from urdf import urdf_of
finally:
    sys.path.remove(str(PEERS))


def test_the_urdf_is_the_nominal_robot_with_its_masses(tmp_path):
    nominal = ec.load_robot(ROBOT_FILE)
    (tmp_path / "robot.urdf").write_text(urdf_of(nominal, np.array([0.1, 0.2, 0.3])), encoding="utf-8")
    read = ec.load_robot(tmp_path / "robot.urdf", tip="target")
    known = {"base": Frame(known=True), "tool": Frame((0.1, 0.2, 0.3), known=True)}
    table = nominal.with_frames(known)
    read = read.with_frames({"base": Frame(known=True), "tool": Frame(known=True)})
    spring = Compliance("linear", (1e-5,))
    q = random_poses(nominal, 20, 1)
    for first, second in (
        (table, read),
        (replace(table, elastic={"2.theta": spring}), replace(read, elastic={"joint_2.theta": spring})),
    ):
        np.testing.assert_allclose(ec.predict(first, q)[0], ec.predict(second, q)[0], atol=1e-12)


@pytest.mark.parametrize("law", run.LAWS)
def test_arms_are_measured_at_their_own_poses_with_the_noise_that_is_said(tmp_path, law):
    arm = arms.Arm(law, 3)
    actual = arms.actual_robot(arm)
    arms.write_arm(arm, tmp_path)
    fitted = np.loadtxt(tmp_path / "fit.csv", delimiter=",", skiprows=1)
    held_out, truth = (np.array(runs.read_points(tmp_path / name)) for name in ("held_out.csv", "truth.csv"))
    assert (len(fitted), len(held_out)) == (60, 200)
    assert {spring.law for spring in actual.elastic.values()} == (set() if law == "rigid" else {law})
    np.testing.assert_array_equal(ec.predict(actual, held_out)[0], truth)
    noise = fitted[:, 6:] - ec.predict(actual, fitted[:, :6])[0]
    assert 0.8 < noise.std() / arms.NOISE < 1.2
    nominal = np.array(runs.read_points(tmp_path / "nominal.csv"))
    assert np.linalg.norm(nominal - truth, axis=1).max() < 0.02  # aligned


def test_lines_of_user_code_are_those_of_the_setting(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import a\n# user code: best, default\nimport b\n\n# why\nfrom exchange import main\n# end of user code\n"
        "c()\n# user code: best\nd()\ne()\n# end of user code\n",
        encoding="utf-8",
    )
    assert tools.lines_of_user_code(script, "default") == 1
    assert tools.lines_of_user_code(script, "best") == 3
    script.write_text("# user code: best\nd()\n", encoding="utf-8")
    with pytest.raises(ValueError, match="not closed"):
        tools.lines_of_user_code(script, "best")


@pytest.mark.parametrize("tool", tools.TOOLS, ids=lambda tool: tool.name)
def test_every_setting_has_user_code(tool):
    assert min(tools.lines_of_user_code(tool.script, setting) for setting in tool.settings) > 3


SCRIPT = """
import os, sys
sys.path.insert(0, PEERS)
from exchange import main

def default(arm):
    (arm.folder.parent / "log").open("a").write("fitted ")
    return lambda q: [[0.0, 0.0, 1e-3], [0.0, 3e-3, 0.0]]

def failing(arm):
    if arm.folder.name == "two":
        raise RuntimeError("no such joint")
    if arm.folder.name == "three":
        os.abort()
    return default(arm)

main({"default": default, "best": failing})
"""


def jobs(folder, monkeypatch, setting, arms):
    monkeypatch.setattr(tools, "HERE", folder)
    (folder / "with_fake.py").write_text(SCRIPT.replace("PEERS", repr(str(PEERS))), encoding="utf-8")
    tool = tools.Tool("fake", "fake", {setting: 1}, ())
    environment = Environment(Path(sys.executable), "fake", {})
    asked = []
    for name in arms:
        (folder / name).mkdir()
        (folder / name / "truth.csv").write_text("x,y,z\n0,0,0\n0,0,0\n", encoding="utf-8")
        (folder / name / "held_out.csv").write_text("q1\n0\n0\n", encoding="utf-8")
        kept = folder / "kept" / f"{name}.json"
        asked.append(runs.Job(tool, setting, "rigid", 0, environment, folder / name, kept))
    return asked


def fitted(asked):
    return runs.run_all(asked, 1, lambda *_: None)


def test_a_result_is_kept_until_its_arm_changes(tmp_path, monkeypatch):
    asked = jobs(tmp_path, monkeypatch, "default", ["one"])
    (first,) = fitted(asked)
    assert (first.status, first.mean, first.largest) == ("done", 2.0, 3.0)
    log = (tmp_path / "log").read_text()
    assert fitted(asked) == [first]
    assert (tmp_path / "log").read_text() == log
    (asked[0].arm / "truth.csv").write_text("x,y,z\n0,0,1e-3\n0,3e-3,0\n", encoding="utf-8")
    assert fitted(asked)[0].mean == 0.0


def test_a_fit_that_fails_or_dies_is_a_result_and_stops_no_other(tmp_path, monkeypatch):
    found = fitted(jobs(tmp_path, monkeypatch, "best", ["one", "two", "three", "four"]))
    assert [result.status for result in found] == ["done", "failed", "failed", "done"]
    assert found[1].note == "RuntimeError: no such joint"
    assert found[2].note == "killed, or not done after 900 s"
    runs.write_results(tmp_path / "results.csv", found)
    again = runs.read_results(tmp_path / "results.csv")
    assert [result.note for result in again] == [result.note for result in found]


def test_a_script_that_does_not_start_says_why(tmp_path, monkeypatch):
    (found,) = fitted(jobs(tmp_path, monkeypatch, "unknown", ["one"]))
    assert found.status == "failed"
    assert "invalid choice: 'unknown'" in found.note


def test_the_stored_run_is_complete():
    counted = Counter((r.tool, r.setting) for r in runs.read_results(run.RESULTS))
    expected = {(tool.name, s): 4 * seeds for tool in tools.TOOLS for s, seeds in tool.settings.items()}
    assert counted == {**expected, ("nominal", "aligned"): 80}


def test_page_and_figure_are_those_of_the_stored_run():
    results, versions = run.stored()
    assert run.PAGE.read_text(encoding="utf-8") == run.page(results, versions)
    assert run.FIGURE.read_text(encoding="utf-8") == run.figure(results)
    ElementTree.fromstring(run.figure(results))
