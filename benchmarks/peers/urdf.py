"""The nominal arm as a URDF."""

from __future__ import annotations

from xml.etree import ElementTree as Tree

import numpy as np
from numpy.typing import NDArray

from elastocal.robot import Robot

INERTIA = {"ixx": "0.01", "iyy": "0.01", "izz": "0.01", "ixy": "0", "ixz": "0", "iyz": "0"}
"""kg m2; readers want one, statics does not."""


def urdf_of(robot: Robot, target: NDArray[np.float64]) -> str:
    """URDF of a modified-DH robot of revolute joints, its tool's mass on the flange.

    Args:
        robot: whose joints become joint_1, joint_2, … about z.
        target: (3,) of the link `target` in the frame of the link `flange` [m].
    """
    root = Tree.Element("robot", name="arm")
    _link(root, "base", 0.0, (0.0, 0.0, 0.0))
    parent = "base"
    for i, row in enumerate(robot.rows, start=1):
        alpha, a, theta, d = (row.geometry.get(key, 0.0) for key in ("alpha", "a", "theta", "d"))
        if theta:
            raise ValueError(f"row {row.name} has a joint offset, which this writer does not know")
        joint = _joint(root, f"joint_{i}", "revolute", (parent, f"link_{i}"))
        _origin(joint, (a, -d * np.sin(alpha), d * np.cos(alpha)), alpha)
        Tree.SubElement(joint, "axis", xyz="0 0 1")
        low, high = row.limits or (-np.pi, np.pi)
        Tree.SubElement(joint, "limit", lower=repr(low), upper=repr(high), effort="1e4", velocity="10")
        _link(root, f"link_{i}", row.mass, row.com)
        parent = f"link_{i}"
    _origin(_joint(root, "flange_joint", "fixed", (parent, "flange")), (0.0, 0.0, 0.0), 0.0)
    _link(root, "flange", robot.tool_load.mass, robot.tool_load.com)
    _origin(_joint(root, "target_joint", "fixed", ("flange", "target")), tuple(target), 0.0)
    _link(root, "target", 0.0, (0.0, 0.0, 0.0))
    Tree.indent(root)
    return Tree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _link(root: Tree.Element, name: str, mass: float, com: tuple[float, ...]) -> None:
    link = Tree.SubElement(root, "link", name=name)
    if mass:
        inertial = Tree.SubElement(link, "inertial")
        _origin(inertial, com, 0.0)
        Tree.SubElement(inertial, "mass", value=repr(float(mass)))
        Tree.SubElement(inertial, "inertia", **INERTIA)


def _joint(root: Tree.Element, name: str, kind: str, links: tuple[str, str]) -> Tree.Element:
    joint = Tree.SubElement(root, "joint", name=name, type=kind)
    Tree.SubElement(joint, "parent", link=links[0])
    Tree.SubElement(joint, "child", link=links[1])
    return joint


def _origin(owner: Tree.Element, xyz: tuple[float, ...], roll: float) -> None:
    Tree.SubElement(owner, "origin", xyz=" ".join(repr(float(value)) for value in xyz), rpy=f"{float(roll)!r} 0 0")
