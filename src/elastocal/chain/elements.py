"""Elementary transforms, and the row of them that is a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastocal.chain.rotations import Array, rotations_from_z, skew

Vector = tuple[float, float, float]

X_AXIS = (1.0, 0.0, 0.0)
Y_AXIS = (0.0, 1.0, 0.0)
Z_AXIS = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Element:
    """One elementary transform: a rotation about, or a translation along, an axis of the running frame.

    `axis` is a unit vector in that frame, `value` its angle [rad] or length [m]. An unnamed element is a
    constant that nobody can identify.
    """

    name: str
    rotation: bool
    axis: Vector
    value: float = 0.0


@dataclass(frozen=True)
class Chain:
    """A row of elements from the instrument to the measured target.

    The chain falls into **frames**: frame 0 is the instrument's, and every moving element starts a new one
    that moves with it. Within a frame all elements are constant, so one pose of the frame places them all.
    **Bodies** are finer: they end at moving elements and at marks, so that what hangs beyond an element is
    the same for all elements of a body.

    Attributes:
        elements: the transforms, in order.
        moving: indices of the elements whose value changes from pose to pose, ascending.
        marks: something is attached after this many elements (a link's mass, the flange, the tool), ascending.
    """

    elements: tuple[Element, ...]
    moving: tuple[int, ...]
    marks: tuple[int, ...]

    @cached_property
    def index(self) -> Mapping[str, int]:
        """Position of each named element."""
        return {element.name: i for i, element in enumerate(self.elements) if element.name}

    @cached_property
    def values(self) -> Array:
        """The elements' own values, (elements,)."""
        return np.array([element.value for element in self.elements])

    @cached_property
    def axes(self) -> Array:
        """The elements' axes in their running frames, (elements, 3)."""
        return np.array([element.axis for element in self.elements])

    @cached_property
    def rotates(self) -> NDArray[np.bool_]:
        """Which elements rotate, (elements,)."""
        return np.array([element.rotation for element in self.elements])

    @cached_property
    def cross_matrices(self) -> tuple[Array, Array]:
        """The axes' cross-product matrices and their squares, (elements, 3, 3) each."""
        cross = skew(self.axes)
        return cross, cross @ cross

    @cached_property
    def moving_index(self) -> NDArray[np.intp]:
        """The moving elements, (moving,)."""
        return np.array(self.moving, dtype=int)

    @cached_property
    def alignments(self) -> Array:
        """Rotations as (moving, 4, 4) that take z onto the moving elements' axes."""
        aligned = np.zeros((len(self.moving), 4, 4))
        aligned[:, 3, 3] = 1.0
        aligned[:, :3, :3] = rotations_from_z(self.axes[self.moving_index])
        return aligned

    @cached_property
    def frame_of(self) -> NDArray[np.intp]:
        """The frame of each element, (elements,); a moving element belongs to the frame that it starts."""
        return np.searchsorted(self.moving, np.arange(len(self.elements)), side="right")

    @cached_property
    def mark_frames(self) -> NDArray[np.intp]:
        """The frame of each mark, (marks,)."""
        return np.searchsorted(self.moving, np.array(self.marks, dtype=int) - 1, side="right")

    @cached_property
    def _body_starts(self) -> NDArray[np.intp]:
        return np.unique(np.array((0, *self.moving, *self.marks), dtype=int))

    @cached_property
    def body_of(self) -> NDArray[np.intp]:
        """The body of each element, (elements,)."""
        return np.searchsorted(self._body_starts, np.arange(len(self.elements)), side="right") - 1

    @cached_property
    def body_frames(self) -> NDArray[np.intp]:
        """The frame of each body, (bodies,)."""
        return np.searchsorted(self.moving, self._body_starts, side="right")

    @cached_property
    def mark_bodies(self) -> NDArray[np.intp]:
        """The body that ends at each mark, (marks,): elements of this and of earlier bodies move the mark."""
        return np.searchsorted(self._body_starts, np.array(self.marks, dtype=int) - 1, side="right") - 1
