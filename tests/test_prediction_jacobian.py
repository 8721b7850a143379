"""Every column of the identification Jacobian against central differences, elastic coupling included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.measurements import Labels, Measurements
from elastocal.parameters import parameters_of
from elastocal.prediction import Model
from elastocal.robot import Frame, Robot, Row
from support.differences import central_difference
from support.robots import random_dh_robot
from support.urdf import compliant, equipped

OTHERS = ("2.alpha", "3.a", "5.beta", "tool.rx", "tool.tz")
AGREES = 1e-6
FLOOR = 1e-3  # [m or rad per unit]: a column below it counts as zero
ROWS = {"position": slice(0, 3), "orientation": slice(3, 6), "distance": slice(6, 7)}


def observations(robot: Robot, rng: np.random.Generator, n: int, wrench: bool) -> Measurements:
    """Of every station, target and load: positions at zero, orientations at the identity."""
    seen = [(None, None, None), ("north", "near", "heavy"), (None, "far", "heavy")]
    station, target, load = zip(*(seen[i % len(seen)] for i in range(n)), strict=True)
    return Measurements(
        q=rng.uniform(-1.5, 1.5, (n, robot.positions)),
        position=np.zeros((n, 3)),
        orientation=np.tile(np.eye(3), (n, 1, 1)),
        distance=np.zeros(n),
        station=Labels.of(station),
        target=Labels.of(target),
        load=Labels.of(load),
        wrench=rng.normal(size=(n, 6)) * ([60.0] * 3 + [20.0] * 3) if wrench else None,
    )


def observed(model: Model, displacements: np.ndarray) -> Model:
    """The model with data that it predicts exactly at these displacements: the residual is zero there."""
    predicted = -residuals(model, displacements)
    rotation = Rotation.from_rotvec(predicted[3:6].T).as_matrix()
    exact = replace(model.data, position=predicted[:3].T, orientation=rotation, distance=predicted[6])
    return replace(model, data=exact)


def residuals(model: Model, displacements: np.ndarray) -> np.ndarray:
    """(7, n) residuals of all kinds at displacements of the parameters."""
    found = np.full((7, len(model.data)), np.nan)
    for part in model.parts(displacements, derivatives=False):
        found[ROWS[part.kind], part.rows] = part.residual
    return found


def columns(model: Model, displacements: np.ndarray) -> np.ndarray:
    """(parameters, 7, n), of position, orientation and distance."""
    found = np.full((len(model.names), 7, len(model.data)), np.nan)
    for part in model.parts(displacements):
        found[:, ROWS[part.kind], part.rows] = part.jacobian[:, :-1].transpose(1, 0, 2)
    return found


def step_of(robot: Robot, name: str) -> float:
    """The step for a parameter: an angle, a length, or a coefficient that gives about as much deflection."""
    element = name.rpartition(".")[0]
    return 2e-6 if element in robot.elastic else 1e-3


def disagreement(robot: Robot, data: Measurements, displacements: np.ndarray) -> dict[str, float]:
    """Largest difference of each column from central differences, relative to its largest entry."""
    model = observed(Model(robot, tuple(parameters_of(robot)), data), displacements)
    jacobian = columns(model, displacements)
    errors = {}
    for number, name in enumerate(model.names):
        step = step_of(robot, name)
        along = np.eye(len(model.names))[number] * step

        def at(t: float, along: np.ndarray = along) -> np.ndarray:
            return residuals(model, displacements + along * t)

        difference = -central_difference(at, 1.0) / step
        errors[name] = np.abs(jacobian[number] - difference).max() / max(np.abs(difference).max(), FLOOR)
    return errors


def assert_derivatives(robot: Robot, data: Measurements, displacements: np.ndarray) -> None:
    errors = disagreement(robot, data, displacements)
    wrong = {name: f"{error:.1e}" for name, error in errors.items() if not error < AGREES}
    assert not wrong


def dh_robot(convention: str, seed: int, prismatic: float, turn: float, slide: float) -> Robot:
    rng = np.random.default_rng(seed)
    robot = equipped(random_dh_robot(rng, convention, prismatic=prismatic), rng)
    return compliant(robot, OTHERS, turn, slide)


@pytest.mark.parametrize("wrench", [False, True], ids=["gravity", "gravity and wrench"])
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("turn", [1e-6, 2e-4], ids=["stiff", "soft"])
def test_every_column_is_the_derivative_of_the_prediction(convention: str, turn: float, wrench: bool) -> None:
    robot = dh_robot(convention, seed=len(convention) + 2 * wrench, prismatic=0.35, turn=turn, slide=turn / 10.0)
    assert {row.joint for row in robot.rows} == {"revolute", "prismatic"}
    assert {row.sign for row in robot.rows} == {-1, 1}
    data = observations(robot, np.random.default_rng(7), n=24, wrench=wrench)
    assert_derivatives(robot, data, np.zeros(len(parameters_of(robot))))


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_columns_are_right_away_from_the_robot_as_it_stands(convention: str) -> None:
    robot = dh_robot(convention, seed=31, prismatic=0.2, turn=5e-5, slide=5e-6)
    names = tuple(parameters_of(robot))
    rng = np.random.default_rng(8)
    displacements = np.array([rng.uniform(-0.1, 0.1) if step_of(robot, n) == 1e-3 else 2e-6 for n in names])
    data = observations(robot, rng, n=16, wrench=True)
    assert_derivatives(robot, data, displacements)


def test_columns_of_a_urdf_robot_are_derivatives_too() -> None:
    rng = np.random.default_rng(12)
    rows = []
    for i in range(1, 7):
        axis = rng.normal(size=3)
        rows.append(
            Row(
                name=f"j{i}",
                joint=("revolute", "revolute", "prismatic", None, "revolute", "revolute")[i - 1],
                origin=Frame(tuple(rng.uniform(-0.5, 0.5, 3)), tuple(rng.uniform(-2.0, 2.0, 3))),
                axis=tuple((axis / np.linalg.norm(axis)).tolist()),
                mass=float(rng.uniform(1.0, 20.0)),
                com=tuple(rng.uniform(-0.2, 0.2, 3)),
            )
        )
    robot = compliant(equipped(Robot("written", "urdf", tuple(rows)), rng), ("j2.rx", "j4.ty"), 1e-4, 1e-5)
    assert_derivatives(robot, observations(robot, rng, n=16, wrench=True), np.zeros(len(parameters_of(robot))))


def test_turning_a_target_about_its_own_origin_moves_it_nowhere_however_soft_the_robot() -> None:
    robot = dh_robot("modified-dh", seed=11, prismatic=0.0, turn=2e-4, slide=2e-5)
    data = observations(robot, np.random.default_rng(7), n=24, wrench=False)
    model = Model(robot, ("target.near.rx",), replace(data, orientation=None, distance=None))
    for part in model.parts(np.zeros(1)):
        assert np.abs(part.jacobian[:, 0]).max() < 1e-12


def test_columns_with_deflections_held_are_those_of_the_rigid_robot() -> None:
    robot = dh_robot("modified-dh", seed=5, prismatic=0.3, turn=2e-4, slide=2e-5)
    data = observations(robot, np.random.default_rng(9), n=12, wrench=True)
    names = tuple(name for name in parameters_of(robot) if name.rpartition(".")[0] not in robot.elastic)
    rigid = replace(robot, elastic={})
    held, free = Model(robot, names, data), Model(rigid, names, data)
    still = np.zeros(len(names))
    for ours, theirs in zip(held.parts(still, held=True), free.parts(still), strict=True):
        np.testing.assert_array_equal(ours.rows, theirs.rows)
        np.testing.assert_allclose(ours.jacobian[:, :-1], theirs.jacobian[:, :-1], rtol=0, atol=1e-13)
