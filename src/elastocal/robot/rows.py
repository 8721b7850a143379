"""Rows: what a Denavit-Hartenberg table or a URDF says of one link and the joint that moves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from elastocal.chain import X_AXIS, Y_AXIS, Z_AXIS, Element, Vector, rotation_about
from elastocal.robot.frames import Frame

Joint = Literal["revolute", "prismatic"]

JOINT_KEYS: Mapping[Joint | None, str] = {"revolute": "theta", "prismatic": "d"}

DH_KEYS = ("alpha", "a", "beta", "b", "theta", "d")

ROTATION_KEYS = ("alpha", "beta", "theta", "rx", "ry", "rz")
"""Of the elements' names, those that end so are rotations."""

_DH_ELEMENTS = {
    "alpha": (True, X_AXIS),
    "a": (False, X_AXIS),
    "beta": (True, Y_AXIS),
    "b": (False, Y_AXIS),
    "theta": (True, Z_AXIS),
    "d": (False, Z_AXIS),
}


@dataclass(frozen=True)
class Row:
    """A link, the elements that lead to its frame, and the joint that moves it.

    Attributes:
        name: parameters are "name.alpha", ...
        joint: "revolute", "prismatic", or None for a fixed row.
        geometry: of a DH row, alpha, a, beta, b, theta, d [rad, m].
        origin: of a URDF row, the joint's origin in the frame before it.
        axis: of a URDF row, the joint's axis in the frame after its origin.
        sign: -1 where the controller counts against the model.
        limits: of the controller's joint position [rad or m].
        mass: [kg] of the link that moves with this row, with its centre `com` [m] in the frame after the row.
    """

    name: str
    joint: Joint | None = None
    geometry: Mapping[str, float] = field(default_factory=dict)
    origin: Frame = field(default_factory=Frame)
    axis: Vector = Z_AXIS
    sign: int = 1
    limits: tuple[float, float] | None = None
    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)

    @property
    def joint_element(self) -> str | None:
        """Name of the element that the joint drives."""
        return f"{self.name}.{JOINT_KEYS[self.joint]}" if self.joint else None


@dataclass(frozen=True)
class Convention:
    """How a row's entries become elements, and how changes of the elements' values are written back."""

    name: str
    elements: Callable[[Row], tuple[Element, ...]]
    displaced: Callable[[Row, Mapping[str, float]], Row]


def _dh_convention(name: str, order: tuple[str, ...]) -> Convention:
    def elements(row: Row) -> tuple[Element, ...]:
        return tuple(Element(f"{row.name}.{key}", *_DH_ELEMENTS[key], row.geometry.get(key, 0.0)) for key in order)

    def displaced(row: Row, deltas: Mapping[str, float]) -> Row:
        moved = {key: row.geometry.get(key, 0.0) + deltas.get(key, 0.0) for key in {**row.geometry, **deltas}}
        return replace(row, geometry=moved)

    return Convention(name, elements, displaced)


def _urdf_elements(row: Row) -> tuple[Element, ...]:
    origin = row.origin.elements(row.name)
    if row.joint is None:
        return origin
    return (*origin, Element(f"{row.name}.{JOINT_KEYS[row.joint]}", row.joint == "revolute", row.axis))


def _urdf_displaced(row: Row, deltas: Mapping[str, float]) -> Row:
    """A URDF has no joint offset: it becomes part of the origin."""
    origin = row.origin.displaced({key: delta for key, delta in deltas.items() if key not in JOINT_KEYS.values()})
    offset = deltas.get(JOINT_KEYS[row.joint], 0.0) if row.joint else 0.0
    axis = np.array(row.axis)
    if row.joint == "revolute" and offset:
        origin = origin.at(origin.translation, origin.rotation @ rotation_about(row.axis, offset))
    elif offset:
        origin = origin.at(origin.translation + origin.rotation @ axis * offset, origin.rotation)
    return replace(row, origin=origin)


CONVENTIONS = {
    convention.name: convention
    for convention in (
        _dh_convention("modified-dh", ("alpha", "a", "beta", "b", "theta", "d")),
        _dh_convention("standard-dh", ("theta", "d", "a", "alpha", "beta", "b")),
        Convention("urdf", _urdf_elements, _urdf_displaced),
    )
}
