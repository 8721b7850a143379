"""Robots of all kinds to export, and readers of the formats that use nothing of elastocal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from io import StringIO

import numpy as np
import polars as pl
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from elastocal.robot import Compliance, Frame, JointMap, Payload, Robot, Row
from support.robots import random_dh_robot
from support.urdf import transform

Array = NDArray[np.float64]

CONVENTIONS = ("modified-dh", "standard-dh", "urdf")


def random_robot(rng: np.random.Generator, convention: str, prismatic: float = 0.3, fixed: bool = True) -> Robot:
    """A rigid robot of random geometry with signs, some sliding joints and limits, and perhaps a fixed row."""
    joints = 7 if fixed else 6
    if convention == "urdf":
        rows = tuple(_urdf_row(rng, f"joint_{i}", rng.random() < prismatic) for i in range(joints))
        robot = Robot("random", "urdf", rows, tool_load=Payload(3.0, (0.1, 0.0, 0.05)))
    else:
        robot = random_dh_robot(rng, convention, joints=joints, prismatic=prismatic)
    rows = tuple(replace(row, sign=int(rng.choice([-1, 1]))) for row in robot.rows)
    if fixed:
        rows = (*rows[:2], replace(rows[2], joint=None, sign=1), *rows[3:])
    rows = tuple(replace(row, limits=(-1.5, 2.0)) if row.joint and i % 2 else row for i, row in enumerate(rows))
    return replace(robot, rows=rows, tool=random_frame(rng), base=random_frame(rng))


def _urdf_row(rng: np.random.Generator, name: str, slides: bool) -> Row:
    axis = rng.standard_normal(3)
    x, y, z = (axis / np.linalg.norm(axis)).tolist()
    kind = "prismatic" if slides else "revolute"
    return Row(name, kind, origin=random_frame(rng), axis=(x, y, z), mass=rng.uniform(1.0, 9.0), com=(0.1, -0.05, 0.2))


def random_frame(rng: np.random.Generator) -> Frame:
    """A known frame anywhere near."""
    x, y, z, roll, pitch, yaw = rng.uniform(-0.9, 0.9, 6).tolist()
    return Frame((x, y, z), (2.0 * roll, pitch, 3.0 * yaw), known=True)


def softened(robot: Robot) -> Robot:
    """The robot with every law on some joint, a joint map and payloads."""
    names = [row.joint_element for row in robot.joints if row.joint == "revolute" and row.joint_element]
    laws = (
        Compliance("linear", (3e-6,)),
        Compliance("hinge", (2e-6, 1e-6), 20.0),
        Compliance("step", (2e-6, 1.5e-6), 30.0),
        Compliance("cubic", (2e-6, -1e-12)),
    )
    return replace(
        robot,
        elastic=dict(zip(names, laws, strict=False)),
        transmission={names[0]: JointMap((1e-4, 2e-5), (-5e-5, 1e-5))},
        loads={"heavy": Payload(12.0, (0.0, 0.05, 0.1))},
    )


def at_its_base(robot: Robot) -> Robot:
    """The robot seen from its own base."""
    return replace(robot, base=Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True), stations={})


def table(text: str) -> list[dict[str, object]]:
    """The lines of a CSV."""
    return pl.read_csv(StringIO(text), schema_overrides={"row": pl.String}).to_dicts()


def frame_of(line: dict[str, object]) -> Array:
    """A transform (4, 4) from x, y, z [mm], roll, pitch and yaw [deg]."""
    xyz = np.array([line[f"{key} [mm]"] for key in "xyz"], dtype=float) / 1e3
    rpy = [line[f"{key} [deg]"] for key in ("roll", "pitch", "yaw")]
    return transform(Rotation.from_euler("xyz", rpy, degrees=True).as_matrix(), xyz)


def about(axis: str, angle: float, distance: float) -> Array:
    """A screw about and along x or z, (4, 4)."""
    step = np.eye(3)["xz".index(axis) * 2] * distance
    return transform(Rotation.from_euler(axis, angle).as_matrix(), step)


def pose_of_table(text: str, modified: bool, q: Sequence[float]) -> Array:
    """The tool's pose (4, 4) in the base frame by a DH table, as a textbook has it."""
    first, *joints, last = table(text)
    reached = frame_of(first)
    for line, position in zip(joints, q, strict=True):
        slides = line["joint"] == "prismatic"
        theta = np.deg2rad(line["theta_offset [deg]"]) + (0.0 if slides else position)
        d = line["d [mm]"] / 1e3 + (position if slides else 0.0)
        normal = about("x", np.deg2rad(line["alpha [deg]"]), line["a [mm]"] / 1e3)
        joint = about("z", theta, d)
        reached = reached @ (normal @ joint if modified else joint @ normal)
    return reached @ frame_of(last)


def pose_of_ur(text: str, q: Sequence[float]) -> Array:
    """The pose (4, 4) of wrist_3 by a kinematics file, joined as ur_description joins it."""
    values: dict[str, dict[str, float]] = {}
    link = ""
    for line in text.splitlines():
        key, _, value = line.strip().partition(": ")
        if line.startswith("    "):
            values[link][key] = float(value)
        elif line.startswith("  ") and line.endswith(":"):
            link = key.rstrip(":")
            values[link] = {}
    reached = np.eye(4)
    links = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
    for name, position in zip(links, q, strict=True):
        found = values[name]
        rotation = Rotation.from_euler("xyz", [found["roll"], found["pitch"], found["yaw"]]).as_matrix()
        origin = transform(rotation, np.array([found["x"], found["y"], found["z"]]))
        reached = reached @ origin @ about("z", position, 0.0)
    return reached
