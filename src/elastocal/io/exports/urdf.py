"""URDF: the geometry as origins, and the whole robot in an element that other programs ignore."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import replace

from elastocal.conversion import rigid
from elastocal.conversion.deviation import AT_BASE
from elastocal.io.exports.exported import Draft, Request
from elastocal.io.exports.losses import losses, tool_note
from elastocal.io.robot_toml import FORMAT, robot_to_toml
from elastocal.io.urdf_extension import EXTENSION
from elastocal.io.urdf_tree import FARTHEST, holds_coupling, urdf_tree
from elastocal.robot import Robot


def urdf(request: Request) -> Draft:
    """The robot as a URDF."""
    robot = request.robot
    root = urdf_tree(robot)
    ElementTree.indent(root, " ")
    extension = ElementTree.SubElement(root, EXTENSION, format=FORMAT)
    extension.text = f"\n{robot_to_toml(robot)}"
    extension.tail = "\n"
    text = ElementTree.tostring(root, encoding="unicode")
    held = {"targets", "masses", *(["coupling"] if robot.coupling and holds_coupling(robot) else [])}
    held |= {"limits"} if robot.coupling is None or "coupling" in held else set()
    return Draft(
        text=f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n',
        readings={"other programs": replace(rigid(robot), base=AT_BASE)},
        cannot_hold=losses(robot, held),
        notes=tuple(_notes(robot)),
        comment="<!--\n{}\n-->\n",
    )


def _notes(robot: Robot) -> Iterator[str]:
    yield from tool_note(robot)
    yield (
        f"The whole robot, with what other programs cannot hold, is in the element <{EXTENSION}>: every elastocal "
        "command reads it back from there."
    )
    if robot.coupling is not None and holds_coupling(robot):
        yield "Coupled joints are held by mimic joints, which not every program heeds."
    elif robot.coupling is not None:
        yield "The joints of the URDF are those of the model: coupling.matrix times the controller's."
    free = [row.name for row in robot.joints if row.joint == "prismatic" and not row.limits]
    if free:
        yield f"Joint {', '.join(free)} has no known limits: ±{FARTHEST:g} m is written."
