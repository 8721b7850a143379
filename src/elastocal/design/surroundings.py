"""What surrounds a robot that is measured: an instrument that must see its target, a floor, boxes to keep out of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, Vector
from elastocal.design.links import Posture, distance_to_box, lowest, moving, posture
from elastocal.errors import InputError
from elastocal.robot import Frame, Robot, assemble
from elastocal.simulation import Region, random_poses
from elastocal.simulation.region import Interval

BLOCK = 4000
"""Poses looked at together."""

CENTRE_POSES = 2000
"""The working centre, which a cone opens towards, is the mean over so many."""

Box = tuple[Interval, Interval, Interval]
"""Least and greatest x, y and z [m]."""

NO_REGION = Region()


@dataclass(frozen=True)
class Surroundings:
    """What rejects a pose.

    Attributes:
        region: where the target must be: above a floor, which the links must be above too, within box, range and cone.
        instrument: its origin in the robot's base frame [m]; None: where the robot file's base (or station) puts it.
        aim: the point in the base frame that the middle of the cone goes through [m]; None: the working centre.
        facing: largest angle between an axis of the target and the direction to the instrument [rad]; None: any.
        axis: that axis, in the target's frame.
        keep_out: boxes in the base frame that no link may enter.
        link_radius: links are this thick about the lines from joint origin to joint origin, tool and target [m].

    Raises:
        InputError: with every fault: a lowest that is above its highest, an angle that is none.
    """

    region: Region = NO_REGION
    instrument: Vector | None = None
    aim: Vector | None = None
    facing: float | None = None
    axis: Vector = (0.0, 0.0, 1.0)
    keep_out: tuple[Box, ...] = ()
    link_radius: float = 0.0

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise InputError(*faults)

    def _faults(self) -> Iterator[str]:
        for number, box in enumerate(self.keep_out, start=1):
            for axis, (low, high) in zip("xyz", box, strict=True):
                if not low < high:
                    order = f"expected the lowest {axis} and then the highest, found {low:g} m and {high:g} m"
                    yield f"keep-out {number}: {order}"
        if self.facing is not None and not 0.0 < self.facing <= np.pi:
            yield f"facing: expected an angle between 0 and 180 deg, found {np.degrees(self.facing):g} deg"
        if not (np.isfinite(self.link_radius) and self.link_radius >= 0.0):
            yield f"link radius: expected 0 or a positive length, found {self.link_radius:g} m"
        if self.aim is not None and self.region.cone is None:
            yield "aim is of the middle of a cone, of which there is none: give a cone too"

    @property
    def looks(self) -> tuple[str, ...]:
        """The constraints that need the instrument's place."""
        given = {"box": self.region.box, "range": self.region.range, "cone": self.region.cone, "facing": self.facing}
        return tuple(name for name, value in given.items() if value is not None)

    def unseen(self) -> Surroundings:
        """The same without an instrument: floor and boxes, which bound the robot's work as well."""
        return Surroundings(Region(floor=self.region.floor), keep_out=self.keep_out, link_radius=self.link_radius)


@dataclass(frozen=True)
class Scene:
    """Surroundings as one station, target and payload have them.

    Attributes:
        robot: with its base at the origin, so that all is in the base frame.
        base: instrument_T_base; only its place is known if the instrument's origin is all that was given.
        centre: (3,) in the base frame, which a cone opens towards.
        moving: which of the robot's links move.
    """

    surroundings: Surroundings
    robot: Robot
    base: Frame
    target: str | None
    centre: Array | None
    moving: NDArray[np.bool_]

    def rejected(self, q: Array) -> dict[str, NDArray[np.bool_]]:
        """Which of the poses q (n, joints) each constraint rejects, (n,) by name."""
        blocks = [self._block(q[start : start + BLOCK]) for start in range(0, len(q), BLOCK)]
        return {name: np.concatenate([block[name] for block in blocks]) for name in (blocks[0] if blocks else ())}

    def _block(self, q: Array) -> dict[str, NDArray[np.bool_]]:
        at = posture(assemble(self.robot, None, self.target, None), q)
        region, base = self.surroundings.region, self.base
        seen = at.target.T @ base.rotation.T + base.translation
        centre = None if self.centre is None else base.rotation @ self.centre + base.translation
        found = region.rejected(seen, base, centre)
        if self.surroundings.facing is not None:
            found["facing"] = self._turned_away(at)
        return found | self._touching(at)

    def _turned_away(self, at: Posture) -> NDArray[np.bool_]:
        instrument = -self.base.rotation.T @ self.base.translation
        towards = instrument[:, None] - at.target
        axis = np.array(self.surroundings.axis)
        along = np.einsum("cn,can,a->n", towards, at.axes, axis / np.linalg.norm(axis))
        return along < np.linalg.norm(towards, axis=0) * np.cos(self.surroundings.facing or 0.0)

    def _touching(self, at: Posture) -> dict[str, NDArray[np.bool_]]:
        starts, ends = at.joints[:-1][self.moving], at.joints[1:][self.moving]
        radius, floor = self.surroundings.link_radius, self.surroundings.region.floor
        found = {}
        if floor is not None:
            found["floor under the links"] = lowest(starts, ends) - radius <= floor
        for number, box in enumerate(self.surroundings.keep_out, start=1):
            low, high = np.array(box).T
            near = distance_to_box(starts, ends, low, high).min(axis=0, initial=np.inf)
            found[f"keep-out {number}"] = near <= radius
        return found


def scene(robot: Robot, surroundings: Surroundings, station: str | None = None, target: str | None = None) -> Scene:
    """Surroundings for one station and target of a robot.

    Raises:
        InputError: a constraint needs the instrument's place, which neither the robot nor the surroundings tell.
    """
    home = replace(robot, base=Frame((0.0,) * 3, (0.0,) * 3, known=True))
    base = _instrument_from_base(robot, surroundings, station)
    # a seed of its own, so that the centre is the same whatever the poses are
    anywhere = posture(assemble(home, None, target, None), random_poses(robot, CENTRE_POSES, 0))
    centre = None if surroundings.aim is None else np.array(surroundings.aim)
    if surroundings.region.cone is not None and centre is None:
        centre = anywhere.target.mean(axis=1)
    return Scene(surroundings, home, base, target, centre, moving(anywhere.joints))


def _instrument_from_base(robot: Robot, surroundings: Surroundings, station: str | None) -> Frame:
    """instrument_T_base; the axes of the base if only the instrument's origin is given."""
    if surroundings.instrument is not None:
        x, y, z = surroundings.instrument
        return Frame((-x, -y, -z), (0.0,) * 3)
    frame = robot.base if station is None else robot.stations[station]
    if frame.xyz is None and not frame.known and surroundings.looks:
        named = "base" if station is None else f"station.{station}"
        raise InputError(
            f"{', '.join(surroundings.looks)}: expected to know where the instrument stands: give its place in the "
            f"base frame (--instrument 2m,0m,1m), or [{named}] in the robot file"
        )
    return frame
