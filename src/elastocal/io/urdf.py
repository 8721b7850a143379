"""URDF in: the chain from the root to a tip, what hangs beside it lumped onto the links that carry it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.files import read_text
from elastocal.io.robot_toml import RESERVED
from elastocal.robot import Frame, Joint, Robot, Row

KINDS: dict[str, Joint | None] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": None,
}


@dataclass
class _Tree:
    """Links and joints of a URDF, and the faults met while reading them."""

    links: dict[str, Element]
    joints: dict[str, Element]
    faults: list[str] = field(default_factory=list)

    def numbers(self, element: Element | None, attribute: str, default: str, count: int) -> Array:
        """The numbers of an attribute, (count,)."""
        text = default if element is None else element.get(attribute, default)
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError:
            values = np.zeros(0)
        if len(values) != count or not np.isfinite(values).all():
            tag = "" if element is None else element.tag
            self.faults.append(f"<{tag} {attribute}={text!r}>: expected {count} number{'s' if count > 1 else ''}")
            return np.zeros(count)
        return values

    def origin(self, element: Element) -> Frame:
        found = element.find("origin")
        x, y, z = self.numbers(found, "xyz", "0 0 0", 3).tolist()
        roll, pitch, yaw = self.numbers(found, "rpy", "0 0 0", 3).tolist()
        return Frame((x, y, z), (roll, pitch, yaw))

    def below(self, link: str) -> list[Element]:
        """The joints that a link carries."""
        return [joint for joint in self.joints.values() if _link(joint, "parent") == link]


def read_urdf(path: Path, tip: str | None = None) -> Robot:
    """The chain of a URDF from its root to the link `tip`, which may be left out where nothing branches.

    Gravity is (0, 0, -9.81) m/s2 in the root's frame. Links beside the chain or beyond the tip add their mass to the
    link that carries them, their joints at zero.

    Raises:
        InputError: it is not a URDF, has a joint that cannot be modelled, or branches and no tip is named.
    """
    text = read_text(path)
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        hint = "; a xacro file has to be expanded first" if "xacro" in text else ""
        raise InputError(f"{path}: not valid XML: {error}{hint}") from None
    if root.tag != "robot":
        raise InputError(f"{path}: expected a <robot>, found a <{root.tag}>")
    tree = _Tree(
        {element.get("name", ""): element for element in root.findall("link")},
        {element.get("name", ""): element for element in root.findall("joint")},
    )
    _check_links(tree, path)
    chain = _chain(tree, path, tip)
    rows = tuple(_row(tree, joint, chain) for joint in chain)
    if not any(row.joint for row in rows):
        tree.faults.append(f"no joint moves between the root and link {tip!r}")
    if tree.faults:
        raise InputError(*(f"{path}: {fault}" for fault in dict.fromkeys(tree.faults)))
    return Robot(root.get("name", path.stem), "urdf", rows)


def _check_links(tree: _Tree, path: Path) -> None:
    faults = []
    for name, joint in tree.joints.items():
        for end in ("parent", "child"):
            link = _link(joint, end)
            if link not in tree.links:
                faults.append(f"{path}: joint {name!r}, {end}: {unknown_name('link', link, tree.links)}")
    children = {_link(joint, "child") for joint in tree.joints.values()}
    roots = [link for link in tree.links if link not in children]
    if len(roots) != 1 and not faults:
        faults.append(f"{path}: expected one root link, found {', '.join(roots) or 'none'}")
    if faults:
        raise InputError(*faults)


def _chain(tree: _Tree, path: Path, tip: str | None) -> list[Element]:
    """The joints from the root to the tip."""
    if tip is None:
        leaves = [link for link in tree.links if not tree.below(link)]
        if len(leaves) != 1:
            raise InputError(f"{path}: the chain branches: name its tip (--tip LINK; valid: {', '.join(leaves)})")
        tip = leaves[0]
    if tip not in tree.links:
        raise InputError(f"{path}: --tip: {unknown_name('link', tip, tree.links)}")
    carriers = {_link(joint, "child"): joint for joint in tree.joints.values()}
    chain: list[Element] = []
    while tip in carriers and len(chain) <= len(tree.joints):
        chain.append(carriers[tip])
        tip = _link(carriers[tip], "parent")
    return chain[::-1]


def _row(tree: _Tree, joint: Element, chain: Iterable[Element]) -> Row:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in KINDS:
        tree.faults.append(f"joint {name!r}: expected type {', '.join(KINDS)}, found {kind!r}")
    if joint.find("mimic") is not None:
        tree.faults.append(
            f"joint {name!r} mimics another, which a URDF chain here cannot: write a robot file with [coupling] instead"
        )
    moves = KINDS.get(kind)
    axis = tree.numbers(joint.find("axis"), "xyz", "1 0 0", 3)
    length = float(np.linalg.norm(axis))
    if moves and not length > 1e-9:
        tree.faults.append(f"joint {name!r}: its axis has no direction")
    limits = None
    if kind in ("revolute", "prismatic") and joint.find("limit") is not None:
        lower, upper = (float(tree.numbers(joint.find("limit"), end, "0", 1)[0]) for end in ("lower", "upper"))
        limits = (lower, upper) if lower < upper else None
    mass, moment = _hanging(tree, _link(joint, "child"), chain)
    x, y, z = (axis / length).tolist() if moves and length > 1e-9 else (0.0, 0.0, 1.0)
    return Row(
        name=f"{name}_joint" if name in RESERVED else name,
        joint=moves,
        origin=tree.origin(joint),
        axis=(x, y, z),
        limits=limits,
        mass=mass,
        com=tuple((moment / mass).tolist()) if mass else (0.0, 0.0, 0.0),
    )


def _hanging(tree: _Tree, link: str, chain: Iterable[Element]) -> tuple[float, Array]:
    """Mass and first moment in the link's frame of a link and of all that it carries beside the chain."""
    inertial = tree.links[link].find("inertial")
    mass, moment = 0.0, np.zeros(3)
    if inertial is not None:
        mass = float(tree.numbers(inertial.find("mass"), "value", "0", 1)[0])
        moment = mass * tree.origin(inertial).translation
    for joint in tree.below(link):
        if joint not in chain:
            origin = tree.origin(joint)
            beside, its_moment = _hanging(tree, _link(joint, "child"), chain)
            mass += beside
            moment = moment + beside * origin.translation + origin.rotation @ its_moment
    return mass, moment


def _link(joint: Element, end: str) -> str:
    """The link at the "parent" or the "child" end of a joint."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")
