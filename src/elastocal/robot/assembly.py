"""A robot put together for one kind of observation: from which station, of which target, with which payload."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array, Chain, Element
from elastocal.elasticity import Spring
from elastocal.robot.model import JointMap, Robot
from elastocal.statics import Mechanism, PointMass


@dataclass(frozen=True)
class Drive:
    """What moves an element: a joint of the model (None: only its elasticity), its sign, its transmission error."""

    joint: int | None
    sign: int = 1
    error: JointMap | None = None


@dataclass(frozen=True)
class Assembly:
    """A chain from the instrument to a target, what hangs on it and what moves it.

    Attributes:
        mechanism: chain and masses; its elastic elements are those of `springs`, in chain order.
        springs: how they give way.
        drives: one for each moving element.
        coupling: (model joints, controller joints), or None.
    """

    mechanism: Mechanism
    springs: tuple[Spring, ...]
    drives: tuple[Drive, ...]
    coupling: Array | None

    def model_positions(self, q: Array) -> Array:
        """Joint positions of the model (model joints, n) at the controller's q (joints, n)."""
        return q if self.coupling is None else self.coupling @ q

    def motion(self, q: Array) -> Array:
        """Positions of the moving elements (moving, n) at the controller's joint positions q (joints, n)."""
        model = self.model_positions(q)
        motion = np.zeros((len(self.drives), q.shape[1]))
        for row, drive in zip(motion, self.drives, strict=True):
            if drive.joint is not None:
                np.multiply(model[drive.joint], drive.sign, out=row)
                if drive.error is not None:
                    row += drive.error.at(model[drive.joint])
        return motion


def assemble(robot: Robot, station: str | None = None, target: str | None = None, load: str | None = None) -> Assembly:
    """Put a robot together for observations from a station (None: the base) of a target (None: the tool's origin).

    Raises:
        KeyError: a name that the robot does not have.
    """
    base = robot.base if station is None else robot.stations[station]
    elements: list[Element] = list(base.elements("base" if station is None else f"station.{station}"))
    marks = [len(elements)]
    for row in robot.row_elements:
        elements += row
        marks.append(len(elements))
    elements += robot.tool.elements("tool")
    marks.append(len(elements))
    if target is not None:
        elements += robot.targets[target].elements(f"target.{target}")

    driven = {row.joint_element: Drive(joint, row.sign) for joint, row in enumerate(robot.joints)}
    for name, error in robot.transmission.items():
        driven[name] = Drive(driven[name].joint, driven[name].sign, error)
    moving = [i for i, element in enumerate(elements) if element.name in driven or element.name in robot.elastic]
    elastic = [i for i in moving if elements[i].name in robot.elastic]
    flange = len(robot.rows)
    payload = [robot.tool_load] + ([robot.loads[load]] if load is not None else [])
    masses = [PointMass(i, row.mass, row.com) for i, row in enumerate(robot.rows, start=1) if row.mass]
    masses += [PointMass(flange, piece.mass, piece.com) for piece in payload if piece.mass]
    return Assembly(
        mechanism=Mechanism(
            chain=Chain(tuple(elements), tuple(moving), tuple(marks)),
            masses=tuple(masses),
            gravity=robot.gravity,
            elastic=tuple(elastic),
        ),
        springs=tuple(robot.elastic[elements[i].name].spring for i in elastic),
        drives=tuple(driven.get(elements[i].name, Drive(None)) for i in moving),
        coupling=None if robot.coupling is None else np.array(robot.coupling),
    )
