"""A robot as a row of elementary transforms, and one pass over it that yields every screw."""

from elastocal.chain.columns import cross, twist_columns
from elastocal.chain.elements import X_AXIS, Y_AXIS, Z_AXIS, Chain, Element, Vector
from elastocal.chain.frames import Frames, forward, orientations, points
from elastocal.chain.placement import Placement, place
from elastocal.chain.rotations import (
    Array,
    rotation_about,
    rotation_from_rpy,
    rotation_vectors,
    rpy_from_rotation,
    skew,
)

__all__ = [
    "X_AXIS",
    "Y_AXIS",
    "Z_AXIS",
    "Array",
    "Chain",
    "Element",
    "Frames",
    "Placement",
    "Vector",
    "cross",
    "forward",
    "orientations",
    "place",
    "points",
    "rotation_about",
    "rotation_from_rpy",
    "rotation_vectors",
    "rpy_from_rotation",
    "skew",
    "twist_columns",
]
