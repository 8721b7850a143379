"""The element <elastocal> of a URDF: the whole robot, as a robot file in TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from elastocal.errors import InputError
from elastocal.io.robot_toml import FORMAT, robot_of
from elastocal.io.urdf_tree import urdf_tree
from elastocal.robot import Robot

EXTENSION = "elastocal"

SAME = 1e-9
"""Numbers of the URDF and of the robot within it that agree to this are the same."""

TOLD = 5
"""So many differences are told."""

JOINT = {
    ".": ("type",),
    "parent": ("link",),
    "child": ("link",),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "mimic": ("joint", "multiplier"),
}

LINK = {"inertial/mass": ("value",), "inertial/origin": ("xyz",)}


def read_extension(path: Path, root: Element, tip: str | None) -> Robot:
    """The robot within a URDF; the URDF around it must be that of this robot, its masses and joints at least.

    Raises:
        InputError: it is no sound robot, or the URDF was changed since it was written.
    """
    if tip is not None:
        raise InputError(f"{path}: --tip: the element <{EXTENSION}> holds the whole robot: leave --tip out")
    element = root.find(EXTENSION)
    found = None if element is None else element.get("format")
    place = f"{path}, <{EXTENSION}>"
    if element is None or found != FORMAT:
        raise InputError(f"{place}: format: expected {FORMAT!r}, found {found!r}")
    try:
        values = tomllib.loads(element.text or "")
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{place}: not valid TOML: {error}") from None
    robot = robot_of(values, place)
    changes = list(_changes(root, urdf_tree(robot)))
    if changes:
        more = [f"{path}: … and {len(changes) - TOLD} more"] if len(changes) > TOLD else []
        remedy = f"{path}: delete <{EXTENSION}> if the URDF around it is right, or export the robot anew"
        raise InputError(*(f"{path}: {change}" for change in changes[:TOLD]), *more, remedy)
    return robot


def _changes(root: Element, expected: Element) -> Iterator[str]:
    """Where joints and masses are not those of the robot within."""
    for kind, parts in (("link", LINK), ("joint", JOINT)):
        there = {element.get("name"): element for element in root.findall(kind)}
        for wanted in expected.findall(kind):
            name = wanted.get("name")
            if name not in there:
                yield f"{kind} {name!r} of <{EXTENSION}> is missing"
                continue
            for part, keys in parts.items():
                for key in keys:
                    value, found = _value(wanted, part, key), _value(there[name], part, key)
                    if not _same(value, found):
                        shown = key if part == "." else f"{part} {key}"
                        yield f"{kind} {name!r}, {shown}: found {found!r}, but {value!r} in <{EXTENSION}>"


def _value(element: Element, part: str, key: str) -> str | None:
    found = element.find(part)
    return None if found is None else found.get(key)


def _same(one: str | None, other: str | None) -> bool:
    if one is None or other is None or one == other:
        return one == other
    try:
        numbers, others = (np.array([float(word) for word in text.split()]) for text in (one, other))
    except ValueError:
        return False
    return numbers.shape == others.shape and bool(np.allclose(numbers, others, rtol=0.0, atol=SAME))
