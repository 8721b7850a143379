"""What the commands print, at 80 columns, against the files in golden/.

To accept what they print now: ELASTOCAL_UPDATE_GOLDEN=1 pytest tests/test_cli_golden.py, then look at the diff.

The measurements lie in golden/ too, so that no random numbers are drawn. Words and layout must agree to the letter,
numbers to one unit of their last printed digit: rounding differs from machine to machine in the fifteenth digit, which
now and then turns the last one that is printed.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

from support.files import Desk, desk

__all__ = ["desk"]

GOLDEN = Path(__file__).with_name("golden")

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

COMMANDS = {
    "calibrate": ("calibrate robot.toml fit.csv --held-out held_out.csv --elastic 2,3,6 -o result", 0),
    "calibrate-poses": ("calibrate robot.toml poses.csv --fix *.beta", 0),
    "calibrate-few": ("calibrate robot.toml few.csv", 1),
    "calibrate-step": ("calibrate robot.toml step.csv --elastic 2:step,3:step", 0),
    "calibrate-step-given": ("calibrate robot.toml step.csv --elastic 2:step,3:cubic --transition 222", 0),
    "export-corrections": ("export result/robot.toml --to corrections-csv -o corrections.csv", 0),
    "export-mdh": ("export result/robot.toml --to mdh-csv -o table.csv", 0),
    "export-urdf": ("export result/robot.toml --to urdf -o robot.urdf", 0),
    "plan": ("plan robot.toml --poses 30 --candidates fit.csv --elastic 2,3:hinge -o plan.csv", 0),
    "reproduce": ("reproduce A-1 b-2", 0),
    "validate": ("validate robot.toml held_out.csv poses.csv", 0),
    "validate-calibrated": ("validate result/robot.toml held_out.csv", 0),
    "validate-refit": ("validate result/robot.toml held_out.csv --refit tool", 0),
    "compensate": ("compensate result/robot.toml targets.csv --nominal robot.toml -o corrected.csv", 0),
    "validate-map": ("validate result/robot.toml held_out.csv --uncertainty-map", 0),
}


def unit(number: str) -> float:
    """One unit of the last printed digit."""
    digits, _, power = number.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


def agree(found: str, expected: str) -> bool:
    """Whether two numbers are the same but for one unit of the last digit."""
    return unit(found) == unit(expected) and abs(float(found) - float(expected)) <= 1.001 * unit(expected)


def assert_agrees(found: str, expected: str) -> None:
    """The same words and layout, the same numbers."""
    assert NUMBER.sub("#", found) == NUMBER.sub("#", expected)
    pairs = zip(NUMBER.findall(found), NUMBER.findall(expected), strict=True)
    assert [(one, other) for one, other in pairs if not agree(one, other)] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_what_is_printed_is_what_was_accepted(desk: Desk, name: str):
    for path in (*GOLDEN.glob("*.csv"), GOLDEN / "robot.toml"):
        shutil.copy(path, desk.folder)
    command, status = COMMANDS[name]
    if "result/" in command:
        desk.done(COMMANDS["calibrate"][0])
    found = "".join(f"{line.rstrip()}\n" for line in desk.done(command, status).splitlines())
    golden = GOLDEN / f"{name}.txt"
    if os.environ.get("ELASTOCAL_UPDATE_GOLDEN"):
        golden.write_text(found, encoding="utf-8")
    assert golden.is_file(), f"accept what is printed: ELASTOCAL_UPDATE_GOLDEN=1 pytest {__file__}"
    assert max(map(len, found.splitlines())) <= 80
    assert_agrees(found, golden.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("found", "same"),
    [("1.2345 mm", True), ("1.2344 mm", True), ("1.2343 mm", False), ("1.234 mm", False), ("1.2345 m", False)],
)
def test_only_the_last_digit_may_differ(found: str, same: bool):
    if same:
        assert_agrees(found, "1.2345 mm")
    else:
        with pytest.raises(AssertionError):
            assert_agrees(found, "1.2345 mm")
