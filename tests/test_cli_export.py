"""The command `export`: what it writes, prints and refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.io import EXPORTS
from support.exports import random_robot, softened, table
from support.files import Desk, desk, flawed, save_simulated
from support.robots import arm

__all__ = ["desk"]


@pytest.fixture
def nominal(desk: Desk) -> Desk:
    """A desk with a nominal robot and an identified one."""
    ec.save_robot(arm(), desk.folder / "nominal.toml")
    ec.save_robot(softened(flawed(arm(), np.random.default_rng(0))), desk.folder / "robot.toml")
    return desk


@pytest.mark.parametrize("to", EXPORTS)
def test_every_format_is_written_and_its_residual_told(nominal: Desk, to: str):
    extra = "--nominal nominal.toml" if to == "corrections-csv" else ""
    printed = nominal.done(f"export robot.toml --to {to} {extra} -o out/file")
    assert "Cannot hold" in printed
    assert "1000 random poses within the joint limits" in " ".join(printed.split())
    assert ", heavy, fitted" in printed
    text = (nominal.folder / "out" / "file").read_text()
    ran = nominal.run(f"export robot.toml --to {to} {extra}")
    assert ran.out == text
    assert "Cannot hold" in ran.err
    found = json.loads(nominal.done(f"export robot.toml --to {to} {extra} --json"))
    assert (found["format"], found["robot"], found["to"], found["file"]) == ("elastocal-export/1", "arm", to, None)
    assert found["text"] == text
    assert found["cannot_hold"]
    residual = found["residuals"][0]
    assert residual.keys() >= {"reading", "load", "refitted", "n", "mean", "max", "rms", "angle"}
    assert residual["n"] == 1000


def test_corrections_know_the_nominal_robot_from_the_result(desk: Desk):
    save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv --elastic 2,3 -o result")
    desk.done("export result/robot.toml --to corrections-csv -o one.csv")
    desk.done("export result/robot.toml --to corrections-csv --nominal robot.toml -o two.csv")
    one, two = (table((desk.folder / name).read_text()) for name in ("one.csv", "two.csv"))
    for line, other in zip(one, two, strict=True):
        for key, value in line.items():
            assert value == (pytest.approx(other[key], abs=1e-8) if isinstance(value, float) else other[key])


def test_an_exported_urdf_predicts_as_the_calibration_does(desk: Desk):
    save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv --elastic 2,3 -o result")
    desk.done("export result/robot.toml --to urdf -o out.urdf")
    one, other = (
        json.loads(desk.done(f"validate {robot} held_out.csv --json"))["residuals"]["held_out"]
        for robot in ("result/robot.toml", "out.urdf")
    )
    assert one == pytest.approx(other, rel=1e-9)


def test_a_urdf_calibrated_and_exported_has_corrections_too(desk: Desk):
    nominal = replace(random_robot(np.random.default_rng(1), "urdf", fixed=False), tool=arm().tool, base=arm().base)
    ec.save_robot(nominal, desk.folder / "robot.toml")
    desk.done("simulate robot.toml --poses 120 --geometry-error 0.5mm,0.5mrad --kinds position,orientation -o fit.csv")
    desk.done("calibrate robot.toml fit.csv -o result")
    desk.done("export result/robot.toml --to corrections-csv -o one.csv")
    desk.done("export result/robot.toml --to corrections-csv --nominal robot.toml -o two.csv")
    assert (desk.folder / "one.csv").read_text().splitlines()[0].count("delta_rx [deg]") == 1
    one, two = (table((desk.folder / name).read_text()) for name in ("one.csv", "two.csv"))
    for line, other in zip(one, two, strict=True):
        for key, value in line.items():
            assert value == (pytest.approx(other[key], abs=1e-6) if isinstance(value, float) else other[key])


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("export robot.toml --to dh-cvs", "--to: no format 'dh-cvs'; did you mean 'dh-csv'? (valid: urdf, dh-csv, "),
        (
            "export robot.toml --to corrections-csv -o x.csv",
            "the nominal robot is not known: name it (--nominal ROBOT)",
        ),
        ("export robot.toml --to urdf --nominal nominal.toml", "--nominal goes with --to corrections-csv"),
        ("export robot.toml --to urdf --longest 10m", "--longest goes with --to dh-csv and mdh-csv"),
        ("export robot.toml --to dh-csv --longest far", "--longest far: expected a number and a unit of length"),
        ("export robot.toml --to urdf -o robot.toml", "robot.toml is an input, which a result never overwrites"),
        (
            "export robot.toml --to corrections-csv --nominal nominal.toml -o nominal.toml",
            "nominal.toml is an input, which a result never overwrites",
        ),
        ("export coupled.toml --to mdh-csv -o x.csv", "the joints of arm are coupled"),
        ("export short.toml --to ur-yaml -o x.yaml", "expected six revolute joints, found 5"),
        (
            "export robot.toml --to corrections-csv --nominal short.toml -o x.csv",
            "the nominal robot has rows 1, 2, 3, ",
        ),
    ],
)
def test_bad_input_is_named_and_nothing_written(nominal: Desk, command: str, message: str):
    unit = tuple(tuple(float(i == j) for j in range(6)) for i in range(6))
    ec.save_robot(replace(arm(), coupling=unit), nominal.folder / "coupled.toml")
    ec.save_robot(replace(arm(), rows=arm().rows[:5]), nominal.folder / "short.toml")
    assert message in nominal.refused(command)[0]


def test_a_robot_too_soft_for_its_load_is_named(nominal: Desk):
    soft = replace(arm(), elastic={"2.theta": softened(arm()).elastic["1.theta"]})
    soft = replace(soft, elastic={"2.theta": replace(soft.elastic["2.theta"], coefficients=(1.0,))})
    ec.save_robot(soft, nominal.folder / "soft.toml")
    assert "2.theta does not settle under its load" in nominal.refused("export soft.toml --to urdf -o x.urdf")[0]
