"""Generic poses and frames: what a robot and an instrument could tell in general, before anything is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.elasticity import CURVES
from elastocal.measurements import Labels, Measurements
from elastocal.prediction import Model
from elastocal.robot import Frame, Robot


def reach(robot: Robot) -> float:
    """Sum of all lengths of the robot's rows and of its tool [m], to compare lengths with angles; 1 without lengths."""
    lengths = [abs(e.value) for row in robot.row_elements for e in row if not e.rotation]
    lengths.append(float(np.linalg.norm(robot.tool.translation)))
    return float(sum(lengths)) or 1.0


def generic_robot(robot: Robot) -> Robot:
    """The robot with every frame that is to be identified at a place where nothing is special."""
    rng = np.random.default_rng(0)
    size = reach(robot)
    frames = {}
    for prefix, frame in robot.frames.items():
        near = 0.1 if prefix.startswith(("tool", "target")) else 1.5
        xyz = near * size * rng.uniform(0.4, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
        rpy = rng.uniform(0.2, 0.7, 3)
        if not frame.known:
            frames[prefix] = Frame(tuple(xyz.tolist()), tuple(rpy.tolist()))
    return robot.with_frames(frames)


def with_middle_torques(model: Model) -> Model:
    """The model with every transition torque where half of the loads are on either side."""
    middle = {}
    for name, loads in model.undeflected_loads(np.zeros(len(model.names))).items():
        compliance = model.robot.elastic[name]
        if CURVES[compliance.law].transition:
            middle[name] = replace(compliance, transition_torque=float(np.median(np.abs(loads))))
    return replace(model, robot=replace(model.robot, elastic={**model.robot.elastic, **middle}))


def generic_measurements(robot: Robot, data: Measurements, count: int) -> Measurements:
    """Observations of the same kinds with the same names as the data's, at about `count` generic poses.

    What was observed at them is not filled in: it does not matter.
    """
    rng = np.random.default_rng(1)
    found = data.combinations
    each = max(6, -(-count // len(found)))
    n = each * len(found)
    q = rng.uniform(-np.pi, np.pi, (n, robot.positions))
    observed = {
        kind: np.repeat([kind in c.kinds for c in found], each) for kind in ("position", "orientation", "distance")
    }

    def filled(kind: str, value: float, shape: tuple[int, ...]) -> np.ndarray | None:
        present = observed[kind]
        if not present.any():
            return None
        return np.where(present.reshape(n, *(1,) * len(shape)), np.full((n, *shape), value), np.nan)

    def names(attribute: str) -> Labels | None:
        values = [getattr(c, attribute) for c in found for _ in range(each)]
        return None if getattr(data, attribute) is None else Labels.of(values)

    blank = Measurements(
        q=q,
        position=filled("position", 0.0, (3,)),
        orientation=filled("orientation", 0.0, (3, 3)),
        distance=filled("distance", 1.0, ()),
        target=names("target"),
        load=names("load"),
        station=names("station"),
    )
    if data.wrench is None:
        return blank
    return replace(blank, wrench=rng.standard_normal((n, 6)) * np.abs(data.wrench).max(axis=0))
