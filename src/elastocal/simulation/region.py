"""Where an instrument sees a robot's target."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.robot import Frame

Interval = tuple[float, float]


@dataclass(frozen=True)
class Region:
    """Where the target must be in a pose that is measured; None: anywhere.

    Attributes:
        floor: least height above the origin of the robot's base, along z of the base frame [m].
        box: lowest and highest x, y and z in the instrument's frame [m].
        range: least and greatest distance from the instrument's origin [m].
        cone: half angle of what the instrument sees [rad], from its origin, about the direction to the robot's working
            centre: the mean of the target's positions over all poses within the joint limits.

    Raises:
        InputError: with every fault: a lowest that is above its highest, an angle that is no half angle.
    """

    floor: float | None = None
    box: tuple[Interval, Interval, Interval] | None = None
    range: Interval | None = None
    cone: float | None = None

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise InputError(*faults)

    def _faults(self) -> Iterator[str]:
        for axis, (low, high) in zip("xyz", self.box or (), strict=False):
            if not low < high:
                yield f"box: expected the lowest {axis} and then the highest, found {low:g} m and {high:g} m"
        if self.range is not None and not 0.0 <= self.range[0] < self.range[1]:
            yield "range: expected the least distance and then the greatest, found {:g} m and {:g} m".format(
                *self.range
            )
        if self.cone is not None and not 0.0 < self.cone <= np.pi:
            yield f"cone: expected a half angle between 0 and 180 deg, found {np.degrees(self.cone):g} deg"

    def rejected(self, position: Array, base: Frame, centre: Array | None = None) -> dict[str, NDArray[np.bool_]]:
        """Which poses each constraint rejects, (poses,) by name.

        Args:
            position: (poses, 3) of the target in the instrument's frame [m].
            base: instrument_T_base.
            centre: (3,) the working centre in the instrument's frame [m], which a cone needs.
        """
        found = {}
        if self.floor is not None:
            found["floor"] = (position - base.translation) @ base.rotation[:, 2] <= self.floor
        if self.box is not None:
            low, high = np.array(self.box).T
            found["box"] = ((position < low) | (position > high)).any(axis=1)
        distance = np.linalg.norm(position, axis=1)
        if self.range is not None:
            found["range"] = (distance < self.range[0]) | (distance > self.range[1])
        if self.cone is not None and centre is not None:
            along = position @ (centre / np.linalg.norm(centre))
            found["cone"] = along < distance * np.cos(self.cone)
        return found
