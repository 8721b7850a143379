"""URDF in: the chain from the root to a tip, what hangs beside it lumped onto the links that carry it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.files import read_text
from elastocal.io.robot_checks import RESERVED
from elastocal.io.urdf_extension import EXTENSION, read_extension
from elastocal.robot import Frame, Joint, Robot, Row

KINDS: dict[str, Joint | None] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": None,
}


XACRO = "{0}: expected a URDF, found a xacro: expand it first: xacro {0} > robot.urdf"


@dataclass
class _Tree:
    """Links and joints of a URDF, and the faults met while reading them."""

    links: dict[str, Element]
    joints: dict[str, Element]
    faults: list[str] = field(default_factory=list)

    def numbers(self, element: Element | None, attribute: str, default: str, count: int, owner: str) -> Array:
        """The numbers of an attribute, (count,), of an element that some joint or link owns."""
        text = default if element is None else element.get(attribute, default)
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError:
            values = np.zeros(0)
        if len(values) != count or not np.isfinite(values).all():
            tag = "" if element is None else element.tag
            expected = f"{count} numbers" if count > 1 else "a number"
            self.faults.append(f"{owner}, {tag} {attribute}: expected {expected}, found {text!r}")
            return np.full(count, np.nan)
        return values

    def origin(self, element: Element, owner: str) -> Frame:
        """The <origin> of a joint or of an <inertial>."""
        found = element.find("origin")
        x, y, z = self.numbers(found, "xyz", "0 0 0", 3, owner).tolist()
        roll, pitch, yaw = self.numbers(found, "rpy", "0 0 0", 3, owner).tolist()
        return Frame((x, y, z), (roll, pitch, yaw))

    def below(self, link: str) -> list[Element]:
        """The joints that a link carries."""
        return [joint for joint in self.joints.values() if _link(joint, "parent") == link]


def read_urdf(path: Path, tip: str | None = None) -> Robot:
    """The chain of a URDF from its root to the link `tip`, which may be left out where nothing branches.

    Gravity is (0, 0, -9.81) m/s2 in the root's frame. Links beside the chain or beyond the tip add their mass to the
    link that carries them, their joints at zero. A robot that `elastocal export` wrote into the element <elastocal> is
    read back from it.

    Raises:
        InputError: it is not a URDF, has a joint that cannot be modelled, or branches and no tip is named.
    """
    root = _root(path)
    if root.find(EXTENSION) is not None:
        return read_extension(path, root, tip)
    tree = _Tree(_by_name(path, root, "link"), _by_name(path, root, "joint"))
    _check_links(tree, path)
    chain = _chain(tree, path, tip)
    rows = tuple(_row(tree, joint, chain) for joint in chain)
    if tree.faults:
        raise InputError(*(f"{path}: {fault}" for fault in dict.fromkeys(tree.faults)))
    if not any(row.joint for row in rows):
        end = _link(chain[-1], "child") if chain else tip
        raise InputError(f"{path}: no joint moves between the root and link {end!r}")
    return Robot(root.get("name", path.stem), "urdf", rows)


def tips_of(path: Path) -> tuple[str, ...]:
    """The links of a URDF that carry no other: where its chain may end; none where <elastocal> in it says where.

    Raises:
        InputError: it is not a URDF.
    """
    root = _root(path)
    if root.find(EXTENSION) is not None:
        return ()
    tree = _Tree(_by_name(path, root, "link"), _by_name(path, root, "joint"))
    carriers = {_link(joint, "parent") for joint in tree.joints.values()}
    return tuple(link for link in tree.links if link not in carriers)


def _root(path: Path) -> Element:
    """The <robot> of a file."""
    text = read_text(path)
    if "<!ENTITY" in text:
        raise InputError(f"{path}: expected no entities (<!ENTITY), which may grow without bound: write them out")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(XACRO.format(path) if "xacro:" in text else f"{path}: not valid XML: {error}") from None
    if any("xacro" in element.tag or "${" in "".join(element.attrib.values()) for element in root.iter()):
        raise InputError(XACRO.format(path))
    if root.tag != "robot":
        raise InputError(f"{path}: expected a <robot>, found a <{root.tag}>")
    return root


def _by_name(path: Path, root: Element, kind: str) -> dict[str, Element]:
    """Links or joints by their names, which must differ."""
    found = root.findall(kind)
    names = [element.get("name", "") for element in found]
    faults = [f"{path}: several {kind}s are named {name!r}: names must differ" for name in _repeated(names) if name]
    if "" in names:
        faults.append(f"{path}: {kind} {names.index('') + 1} has no name")
    if faults:
        raise InputError(*faults)
    return dict(zip(names, found, strict=True))


def _repeated(names: Iterable[str]) -> list[str]:
    return [name for name, count in Counter(names).items() if count > 1]


def _check_links(tree: _Tree, path: Path) -> None:
    """Raise InputError unless links and joints make one tree."""
    faults = []
    for name, joint in tree.joints.items():
        for end in ("parent", "child"):
            link = _link(joint, end)
            if not link:
                faults.append(f"joint {name!r}: expected a <{end} link=…>, found none")
            elif link not in tree.links:
                faults.append(f"joint {name!r}, {end}: {unknown_name('link', link, tree.links)}")
    children = [_link(joint, "child") for joint in tree.joints.values()]
    faults += [f"link {link!r} is the child of several joints: expected one" for link in _repeated(children) if link]
    roots = [link for link in tree.links if link not in children]
    if not faults and len(roots) != 1:
        found = ", ".join(roots) or ("none: its joints go round in a loop" if tree.links else "no link at all")
        faults.append(f"expected one root link, found {found}")
    if faults:
        raise InputError(*(f"{path}: {fault}" for fault in faults))


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
    while tip in carriers:
        if carriers[tip] in chain:
            raise InputError(f"{path}: joint {carriers[tip].get('name')!r} is part of a loop")
        chain.append(carriers[tip])
        tip = _link(carriers[tip], "parent")
    return chain[::-1]


def _row(tree: _Tree, joint: Element, chain: Iterable[Element]) -> Row:
    name, kind = joint.get("name", ""), joint.get("type", "")
    owner = f"joint {name!r}"
    if kind not in KINDS:
        *others, last = KINDS
        tree.faults.append(f"{owner}: expected type {', '.join(others)} or {last}, found {kind or 'none'}")
    if joint.find("mimic") is not None:
        tree.faults.append(f"{owner} mimics another, which this reader cannot: write a robot file with [coupling]")
    moves = KINDS.get(kind)
    axis = tree.numbers(joint.find("axis"), "xyz", "1 0 0", 3, owner)
    length = float(np.linalg.norm(axis))
    if moves and length <= 1e-9:
        tree.faults.append(f"{owner}, axis xyz: expected a direction, found zero length")
    mass, moment = _hanging(tree, _link(joint, "child"), chain)
    x, y, z = (axis / length).tolist() if moves and length > 1e-9 else (0.0, 0.0, 1.0)
    return Row(
        name=f"{name}_joint" if name in RESERVED else name,
        joint=moves,
        origin=tree.origin(joint, owner),
        axis=(x, y, z),
        limits=_limits(tree, joint, owner) if kind in ("revolute", "prismatic") else None,
        mass=mass,
        com=tuple((moment / mass).tolist()) if mass else (0.0, 0.0, 0.0),
    )


def _limits(tree: _Tree, joint: Element, owner: str) -> tuple[float, float] | None:
    """Of the joint's position; None where both are the same, as exporters write that know none."""
    found = joint.find("limit")
    lower, upper = (float(tree.numbers(found, end, "0", 1, owner)[0]) for end in ("lower", "upper"))
    if lower > upper:
        tree.faults.append(f"{owner}, limit: expected lower below upper, found {lower:g} and {upper:g}")
    return (lower, upper) if lower < upper else None


def _hanging(tree: _Tree, link: str, chain: Iterable[Element]) -> tuple[float, Array]:
    """Mass and first moment in the link's frame of a link and of all that it carries beside the chain."""
    inertial, owner = tree.links[link].find("inertial"), f"link {link!r}"
    mass, moment = 0.0, np.zeros(3)
    if inertial is not None:
        mass = float(tree.numbers(inertial.find("mass"), "value", "0", 1, owner)[0])
        moment = mass * tree.origin(inertial, owner).translation
    if mass < 0.0:
        tree.faults.append(f"{owner}, mass value: expected 0 or a positive number, found {mass:g}")
    for joint in tree.below(link):
        if joint not in chain:
            origin = tree.origin(joint, f"joint {joint.get('name')!r}")
            beside, its_moment = _hanging(tree, _link(joint, "child"), chain)
            mass += beside
            moment = moment + beside * origin.translation + origin.rotation @ its_moment
    return mass, moment


def _link(joint: Element, end: str) -> str:
    """The link at the "parent" or the "child" end of a joint."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")
