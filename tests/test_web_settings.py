"""Settings of the page, and the command line that does the same."""

from __future__ import annotations

import json
import shlex
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

import elastocal as ec
from elastocal.parameters import parameters_of
from elastocal.web.command import arguments
from elastocal.web.runs import Run
from elastocal.web.settings import Settings, settings_of_form
from support.files import ROBOT, URDF, Desk, desk
from support.web import SETTINGS, Page, files, page, words

__all__ = ["desk", "files", "page"]

FORMS = {
    "plain": {},
    "laws": {"law 2": "step", "law 3": "hinge", "law 5": "cubic", "transition": "given", "torques": "150, 60"},
    "ga": {"law 2": "step", "transition": "ga", "population": "20", "generations": "5", "non_negative": "on"},
    "fit": {"holdout": "25", "loss": "huber", "seed": "3"},
    "maps": {"maps": "orders", "orders": "4", "law 2": "linear", "prior": "on"},
    "groups": {"groups": ["offsets"], "fix": "2.theta", "law 2": "linear", "law 3": "rigid"},
    "patterns": {"identify": "*.theta 3.*", "bootstrap": "50"},
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_the_command_shown_is_one_that_calibrate_takes(form: dict[str, str], desk: Desk, files: dict[str, bytes]):
    """What the page would run, run as a command line: same meaning, no complaint."""
    desk.write(robot_toml=files["robot.toml"], fit_csv=files["fit.csv"])
    settings = settings_of_form(Settings(), _lists(SETTINGS | form))
    given = arguments(settings, ec.load_robot(desk.folder / "robot.toml"), "robot.toml", ["fit.csv"], [], "result")
    if "--generations" in given:
        assert given[given.index("--generations") + 1] == "5"
    ran = desk.run(shlex.join(given))
    assert ran.status in (0, 1), ran.err
    said = json.loads((desk.folder / "result" / "result.json").read_text(encoding="utf-8"))["settings"]
    assert said["elastic"] == {
        name[4:]: law for name, law in form.items() if name.startswith("law ") and law != "rigid"
    }
    assert said["loss"] == form.get("loss", "linear")
    assert said["seed"] == int(form.get("seed", "0"))
    assert said["holdout"] == (0.25 if "holdout" in form else None)
    assert bool(said["prior"]) == ("prior" in form)
    assert str(said["transmission"]) == (form["orders"] if form.get("maps") == "orders" else "0")
    assert said["bootstrap"] == int(form.get("bootstrap", "0"))
    if "torques" in form:
        assert said["transition"] == [150.0, 60.0]


def _lists(form: dict[str, str | list[str]]) -> dict[str, list[str]]:
    return {name: [value] if isinstance(value, str) else value for name, value in form.items()}


@pytest.mark.parametrize("convention", ["modified-dh", "urdf"])
def test_groups_left_out_are_fixed_and_nothing_else(convention: str, tmp_path: Path):
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "r.toml").write_text(ROBOT)
    robot = ec.load_robot(tmp_path / ("r.urdf" if convention == "urdf" else "r.toml"))
    given = arguments(Settings(groups=("offsets",)), robot, "r", ["d"], [], "o")
    fixed = given[given.index("--fix") + 1 : given.index("-o")]
    matched = {name for name in parameters_of(robot) if any(fnmatchcase(name, pattern) for pattern in fixed)}
    rows = {e.name for row in robot.row_elements for e in row if e.name} - {r.joint_element for r in robot.joints}
    assert matched == rows


@pytest.mark.parametrize(
    ("form", "fault"),
    [
        ({"seed": "-1"}, "seed: expected a whole number of at least 0"),
        ({"population": "1"}, "population: expected a whole number of at least 2"),
        ({"bootstrap": "many"}, "bootstrap: expected a whole number"),
        ({"holdout": "120"}, "hold out: expected 0 to 99 %"),
        ({"loss": "l1"}, "loss: expected linear, huber, cauchy"),
        ({"law 2": "soft"}, "law 2: expected rigid, linear"),
        ({"law 2": "step", "transition": "given", "torques": "x"}, "transition torques: expected numbers"),
        ({"identify": "9.*"}, "parameter matches"),
    ],
)
def test_settings_that_make_no_sense_are_told_and_not_run(
    page: Page, files: dict[str, bytes], form: dict[str, str], fault: str
):
    run = page.new(files)
    for address in (f"{run}/settings", f"{run}/start"):
        got = page.client.post(address, data=SETTINGS | form)
        assert fault in words(got.text)
        assert "Calibrate</button>" not in got.text
    assert Run(page.run_folder(run)).record is None
