"""Frames of a robot: the base (or a station), the tool, the targets, and the origins of a URDF's joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.chain import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Array,
    Element,
    Vector,
    rotation_about,
    rotation_from_rpy,
    rotation_vectors,
    rpy_from_rotation,
)

FRAME_KEYS = ("tx", "ty", "tz", "rx", "ry", "rz")
_AXES = (X_AXIS, Y_AXIS, Z_AXIS)


@dataclass(frozen=True)
class Frame:
    """A rigid transform that a calibration may identify.

    Attributes:
        xyz: translation [m]; None where there is no first guess.
        rpy: rotation about the fixed axes x, y, z in this order [rad]; None where there is no first guess.
        known: taken as it is, not identified.
    """

    xyz: Vector | None = None
    rpy: Vector | None = None
    known: bool = False

    @cached_property
    def translation(self) -> Array:
        """(3,) [m], zero without a first guess."""
        return np.array(self.xyz or (0.0, 0.0, 0.0))

    @cached_property
    def rotation(self) -> Array:
        """(3, 3), the identity without a first guess."""
        return rotation_from_rpy(self.rpy or (0.0, 0.0, 0.0))

    def elements(self, name: str) -> tuple[Element, ...]:
        """Tx Ty Tz, the rotation as one constant, and Rx Ry Rz at zero: small rotations about the frame as it stands.

        So no orientation of the frame makes its parameters lose rank, as Euler angles do.
        """
        shifts = [
            Element(f"{name}.{k}", False, a, v) for k, a, v in zip(FRAME_KEYS[:3], _AXES, self.translation, strict=True)
        ]
        turns = [Element(f"{name}.{k}", True, a) for k, a in zip(FRAME_KEYS[3:], _AXES, strict=True)]
        vector = rotation_vectors(self.rotation[:, :, None])[:, 0]
        angle = float(np.linalg.norm(vector))
        x, y, z = vector / angle if angle > 0.0 else Z_AXIS
        return (*shifts, Element("", True, (float(x), float(y), float(z)), angle), *turns)

    def displaced(self, deltas: Mapping[str, float]) -> Frame:
        """Add to tx, ty, tz [m]; turn by Rx Ry Rz [rad] about the frame's own axes."""
        if not deltas:
            return self
        shift = [deltas.get(key, 0.0) for key in FRAME_KEYS[:3]]
        turns = [rotation_about(a, deltas.get(k, 0.0)) for k, a in zip(FRAME_KEYS[3:], _AXES, strict=True)]
        return self.at(self.translation + shift, self.rotation @ turns[0] @ turns[1] @ turns[2])

    def at(self, translation: Array, rotation: Array) -> Frame:
        """The frame put at a translation (3,) and a rotation (3, 3)."""
        x, y, z = translation.tolist()
        return replace(self, xyz=(x, y, z), rpy=rpy_from_rotation(rotation))
