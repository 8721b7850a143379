"""The kinematics file of Universal Robots' ROS packages (ur_calibration writes it, ur_description reads it)."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np

from elastocal.chain import Array, rpy_from_rotation
from elastocal.conversion import aligned_joints, frame_of, homogeneous, rigid
from elastocal.conversion.deviation import AT_BASE
from elastocal.errors import InputError
from elastocal.io.exports.dh import frame_numbers
from elastocal.io.exports.exported import Draft, Request
from elastocal.io.exports.losses import losses, require_uncoupled, tool_note
from elastocal.robot import Frame, Robot, Row

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")

KEYS = ("x", "y", "z", "roll", "pitch", "yaw")

NONE = 1e-9
"""A transform that differs from the identity by less [rad or m] is none."""


def ur_yaml(request: Request) -> Draft:
    """The robot's joints as origins, each about z of the link that it moves; wrist_3 is the flange."""
    robot = request.robot
    require_uncoupled(robot, "ur-yaml")
    if [row.joint for row in robot.joints] != ["revolute"] * len(LINKS):
        found = ", ".join(str(row.joint) for row in robot.joints)
        raise InputError(f"--to ur-yaml: expected six revolute joints, found {len(robot.joints)} ({found})")
    joints, end = aligned_joints(robot)
    origins = [joint.before for joint in joints]
    numbers = [[*(origin[:3, 3] + 0.0).tolist(), *rpy_from_rotation(origin[:3, :3])] for origin in origins]
    lines = [line for link, values in zip(LINKS, numbers, strict=True) for line in _block(link, values)]
    return Draft(
        text="\n".join(["kinematics:", *lines, f"  hash: {_hash(lines)}", ""]),
        readings={"ur_description": _read(robot, origins, end)},
        cannot_hold=(*losses(robot), *_tool_loss(robot, end)),
        notes=(
            *tool_note(robot),
            "The first frame is the controller's base (base_link_inertia of ur_description). The hash is of these "
            "numbers: the driver compares it with the controller's and says that they differ.",
        ),
        comment="{}\n",
    )


def _block(link: str, values: list[float]) -> list[str]:
    return [f"  {link}:", *(f"    {key}: {value + 0.0!r}" for key, value in zip(KEYS, values, strict=True))]


def _hash(lines: list[str]) -> str:
    return f"calib_{int.from_bytes(hashlib.sha256(chr(10).join(lines).encode()).digest()[:8], 'big')}"


def _read(robot: Robot, origins: list[Array], end: Array) -> Robot:
    """What ur_description makes of it, with the tool given to it apart, from wrist_3 on."""
    rows = tuple(
        Row(row.name, "revolute", origin=frame_of(origin), limits=row.limits)
        for row, origin in zip(robot.joints, origins, strict=True)
    )
    tool = end @ homogeneous(robot.tool.rotation, robot.tool.translation)
    return replace(rigid(robot), convention="urdf", rows=rows, base=AT_BASE, tool=frame_of(tool))


def _tool_loss(robot: Robot, end: Array) -> list[str]:
    """Frames after wrist_3, which are the user's to give."""
    tool = Frame().at(robot.tool.translation, robot.tool.rotation)
    whole = end @ homogeneous(tool.rotation, tool.translation)
    if np.abs(whole - np.eye(4)).max() < NONE:
        return []
    numbers = frame_numbers(frame_of(whole))
    xyz, rpy = (" ".join(f"{value:.6f}" for value in part) for part in (numbers[:3], numbers[3:]))
    return [f"tool: from wrist_3 (tool0) it is at xyz {xyz} mm, rpy {rpy} deg, as the residuals take it"]
