"""The command `reproduce`: its figures, its tables, and cases alone."""

from __future__ import annotations

import json
from inspect import signature
from typing import Any

import pytest

import elastocal as ec
from elastocal.cli.reproduce import reproduce
from elastocal.reproduction import CASES, GENETIC, SEED
from support.files import Desk, desk

__all__ = ["desk"]

QUICK = "--population 8 --generations 3"


def found(desk: Desk, names: str) -> dict[str, Any]:
    """What `--json` prints."""
    return json.loads(desk.done(f"reproduce {names} --json"))


def is_length(value: object) -> bool:
    """Whether a figure is an error in metres."""
    return isinstance(value, float) and 0.0 < value < 0.02


def test_json_has_all_figures_of_both_papers(desk: Desk):
    figures = found(desk, QUICK)
    cases = figures["joint-stiffness-analysis"]
    assert list(cases) == [case.name for case in CASES]
    for case in cases.values():
        assert all(is_length(case[whose][key]) for whose in ("paper", "ours") for key in ("mean", "max"))
        assert len(case["parameters"]) == 26
    ladder = figures["nonlinear-joint-stiffness"]
    assert list(ladder) == ["before", "rigid", "linear", "step-ga", "step-exact", "hinge"]
    assert is_length(ladder["before"]["mean"])
    assert is_length(ladder["before"]["max"])
    assert ladder["before"]["paper"] == {"mean": 3.52e-3, "max": 8.22e-3}
    for name in ("rigid", "linear", "step-ga", "step-exact", "hinge"):
        rung = ladder[name]
        assert all(is_length(rung[which][key]) for which in ("calibrated", "evaluated") for key in ("mean", "max"))
    assert ladder["step-exact"]["paper"]["evaluated"] == {"mean": 1.67e-4, "max": 6.05e-4}
    for key in ("chosen", "slips"):
        assert set(figures[key]) == {"joint-stiffness-analysis", "nonlinear-joint-stiffness"}


def test_what_is_chosen_is_the_default():
    defaults = {name: option.default for name, option in signature(reproduce).parameters.items()}
    assert (defaults["population"], defaults["generations"]) == (GENETIC.population, GENETIC.generations)
    assert defaults["seed"] == SEED


def test_every_chosen_input_has_a_reason(desk: Desk):
    figures = found(desk, "A-1 rigid")
    for chosen in figures["chosen"].values():
        assert all(entry["what"] and entry["value"] and entry["reason"] for entry in chosen)
    told = desk.done("reproduce A-1 rigid")
    assert told.count("Chosen: ") == sum(map(len, figures["chosen"].values()))
    assert told.count("\n Slip: ") == sum(map(len, figures["slips"].values()))


@pytest.mark.parametrize("name", [case.name for case in CASES])
def test_a_case_can_be_run_alone(desk: Desk, name: str):
    figures = found(desk, name)
    assert list(figures["joint-stiffness-analysis"]) == [name]
    assert "nonlinear-joint-stiffness" not in figures
    compact = found(desk, name.replace("-", ""))
    assert compact == figures


@pytest.mark.parametrize("name", ["rigid", "linear", "step-ga", "step-exact", "hinge"])
def test_a_rung_can_be_run_alone(desk: Desk, name: str):
    figures = found(desk, f"{name} {QUICK}")
    assert list(figures["nonlinear-joint-stiffness"]) == ["before", name]
    assert "joint-stiffness-analysis" not in figures


def test_a_paper_can_be_run_alone(desk: Desk):
    assert len(found(desk, "stiffness")["joint-stiffness-analysis"]) == 9
    assert len(found(desk, f"nonlinear {QUICK}")["nonlinear-joint-stiffness"]) == 6


def test_unknown_cases_are_refused_all_at_once(desk: Desk):
    first, second = desk.refused("reproduce a-9 b1 steps")
    assert first.startswith("no case 'a-9'; did you mean")
    assert second.startswith("no case 'steps'")
    assert all(name in first for name in ("A-1", "a-1", "b-2", "hinge", "nonlinear", "stiffness"))


def test_superfluous_compliances_are_called_what_they_are(desk: Desk):
    told = " ".join(desk.done("reproduce b-2").split())
    for joint in ("4", "5", "6"):
        assert f"Compliance {joint}.theta.c is zero within its uncertainty" in told
    assert "The stiffness of joints 4, 5, 6 is no quantity here" in told
    assert "-49.598" in told
    assert told.count("insignificant") == 3


def test_compliances_are_kept_from_becoming_negative(desk: Desk):
    rows = found(desk, "b-2 --non-negative")["joint-stiffness-analysis"]["b-2"]["stiffness"]
    assert min(row["compliance"] for row in rows) == 0.0
    assert [row["ours"] for row in rows if not row["compliance"]] == [None]


def test_a_seed_gives_another_robot_and_the_same_one_again(desk: Desk):
    one, again, other = (found(desk, f"linear step-ga --seed {seed} {QUICK}") for seed in (3, 3, 4))
    assert one == again
    assert one["nonlinear-joint-stiffness"] != other["nonlinear-joint-stiffness"]


def test_the_inputs_can_be_calibrated_from_files(desk: Desk):
    figures = found(desk, "b-1 rigid -o inputs")
    parameters = [row["name"] for row in figures["joint-stiffness-analysis"]["b-1"]["parameters"]]
    command = "calibrate inputs/stiffness-nominal.toml inputs/stiffness-B.csv --elastic 2,3 --json --identify "
    result = json.loads(desk.done(command + " ".join(parameters)))
    ours = figures["joint-stiffness-analysis"]["b-1"]["ours"]["mean"]
    assert result["residuals"]["calibrated"]["mean"] == pytest.approx(ours, rel=1e-3)
    actual = ec.load_robot(desk.folder / "inputs" / "ha006-actual.toml")
    assert {compliance.law for compliance in actual.elastic.values()} == {"harmonic-drive"}
    checked = json.loads(desk.done("validate inputs/ha006-nominal.toml inputs/ha006-calibration.csv --json"))
    before = figures["nonlinear-joint-stiffness"]["before"]["mean"]
    assert checked["residuals"]["held_out"]["mean"] == pytest.approx(before, rel=1e-9)
