"""A robot as the links and joints of a URDF."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from elastocal.chain import Array, Vector, rpy_from_rotation
from elastocal.conversion import Segment, segments
from elastocal.robot import Frame, Robot

FARTHEST = 50.0
"""A URDF wants limits of a prismatic joint: these [m] where none are known."""

IDENTITY = np.eye(4)


class Mimic(NamedTuple):
    """A joint's position is another's times a factor."""

    joint: str
    multiplier: float


@dataclass
class Tree:
    """Links and joints as they grow; names are unique among each."""

    root: Element
    names: dict[str, set[str]] = field(default_factory=lambda: {"link": set(), "joint": set()})

    def name(self, kind: str, wish: str) -> str:
        """The name wished for, or one like it that is free."""
        while wish in self.names[kind]:
            wish += "_"
        self.names[kind].add(wish)
        return wish

    def link(self, wish: str, mass: float = 0.0, com: Sequence[float] = (0.0, 0.0, 0.0)) -> str:
        """Add a link; its inertia is not known, so its mass is a point."""
        name = self.name("link", wish)
        link = ElementTree.SubElement(self.root, "link", name=name)
        if mass:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "origin", xyz=_numbers(com), rpy="0 0 0")
            ElementTree.SubElement(inertial, "mass", value=repr(float(mass)))
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
        return name

    def joint(self, name: str, kind: str, parent: str, child: str, origin: tuple[Array, Sequence[float]]) -> Element:
        """Add a joint whose name is free, at xyz (3,) and rpy (3,)."""
        joint = ElementTree.SubElement(self.root, "joint", name=name, type=kind)
        ElementTree.SubElement(joint, "origin", xyz=_numbers(origin[0]), rpy=_numbers(origin[1]))
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=child)
        return joint

    def fixed(self, wish: str, parent: str, origin: tuple[Array, Sequence[float]], mass: Sequence[float] = ()) -> str:
        """Add a link fixed to another, with (mass, x, y, z) if it has one."""
        child = self.link(wish, *((mass[0], mass[1:]) if mass else ()))
        self.joint(self.name("joint", f"{child}_fixed"), "fixed", parent, child, origin)
        return child


def urdf_tree(robot: Robot) -> Element:
    """The <robot> of a URDF with the robot's geometry, limits and masses."""
    tree = Tree(Element("robot", name=robot.name))
    tree.names["joint"].update(row.name for row in robot.rows)
    model_joints = iter(range(len(robot.joints)))
    reached, link = IDENTITY, tree.link("base_link")
    for segment in segments(robot):
        # a URDF's own numbers are kept to the last digit
        own = robot.convention == "urdf"
        origin = _of_frame(segment.row.origin) if own else _of_matrix(reached @ segment.before)
        if segment.row.joint:
            link = _moving(tree, robot, segment, next(model_joints), link, origin)
        else:
            com = _moved(np.eye(4), segment.row.com)
            child = tree.link(_link_name(segment.row.name), segment.row.mass, com)
            tree.joint(segment.row.name, "fixed", link, child, origin)
            link = child
        reached = segment.after
    load = robot.tool_load
    flange = tree.fixed("flange", link, _of_matrix(reached), (load.mass, *load.com))
    tool = tree.fixed("tool0", flange, _of_frame(robot.tool))
    for name, frame in robot.targets.items():
        tree.fixed(f"target_{name}", tool, _of_frame(frame))
    return tree.root


def holds_coupling(robot: Robot) -> bool:
    """Whether mimic joints can hold the coupling: each joint of the model moves with its own one, and with others."""
    matrix = np.array(robot.coupling)
    return matrix.shape[0] == matrix.shape[1] and bool((np.diag(matrix) == 1.0).all())


def _moving(
    tree: Tree, robot: Robot, segment: Segment, joint: int, parent: str, origin: tuple[Array, Sequence[float]]
) -> str:
    """The joint of a row, after a mimic joint on the same axis for each other joint that moves it too."""
    row = segment.row
    for mimic in _mimics(robot, joint):
        name = tree.name("joint", f"{row.name}_with_{mimic.joint}")
        between = tree.link(f"{name}_link")
        moving = tree.joint(name, "continuous" if row.joint == "revolute" else "prismatic", parent, between, origin)
        _move(moving, segment.axis, (-FARTHEST, FARTHEST) if row.joint == "prismatic" else None)
        ElementTree.SubElement(moving, "mimic", joint=mimic.joint, multiplier=repr(mimic.multiplier), offset="0")
        parent, origin = between, _of_matrix(IDENTITY)
    child = tree.link(_link_name(row.name), row.mass, _moved(segment.after, row.com))
    limits = row.limits if robot.coupling is None or holds_coupling(robot) else None
    kind: str = row.joint or "fixed"
    if kind == "revolute" and limits is None:
        kind = "continuous"
    moving = tree.joint(row.name, kind, parent, child, origin)
    _move(moving, segment.axis, limits or ((-FARTHEST, FARTHEST) if kind == "prismatic" else None))
    return child


def _mimics(robot: Robot, joint: int) -> Iterator[Mimic]:
    if robot.coupling is not None and holds_coupling(robot):
        for other, factor in enumerate(robot.coupling[joint]):
            if other != joint and factor:
                yield Mimic(robot.joints[other].name, float(factor))


def _move(joint: Element, axis: Vector, limits: tuple[float, float] | None) -> None:
    """Axis and limits; effort and velocity, which a URDF wants too, are not known."""
    ElementTree.SubElement(joint, "axis", xyz=_numbers(axis))
    if limits:
        lower, upper = (repr(float(limit)) for limit in limits)
        ElementTree.SubElement(joint, "limit", lower=lower, upper=upper, effort="0", velocity="0")


def _link_name(row: str) -> str:
    return f"{row.removesuffix('_joint')}_link"


def _moved(transform: Array, com: Sequence[float]) -> Sequence[float]:
    return tuple((transform[:3, :3] @ com + transform[:3, 3]).tolist())


def _of_matrix(transform: Array) -> tuple[Array, Sequence[float]]:
    return transform[:3, 3], rpy_from_rotation(transform[:3, :3])


def _of_frame(frame: Frame) -> tuple[Array, Sequence[float]]:
    return frame.translation, frame.rpy or (0.0, 0.0, 0.0)


def _numbers(values: Sequence[float] | Array) -> str:
    # adding zero makes minus zero plain
    return " ".join(repr(float(value) + 0.0) for value in values)
