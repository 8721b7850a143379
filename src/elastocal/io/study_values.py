"""Studies as values: what is simulated, what is varied, how often, and what is told of it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import Any

from elastocal.io.robot_toml import robot_to_toml
from elastocal.robot import Robot

MEASURES = ("coverage", "recommendation", "transition", "outliers")
"""What a study may tell beyond held-out errors."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Spring:
    """Compliance of an element of the actual robot, drawn for each repeat; SI.

    Attributes:
        compliance: least and greatest at small loads [rad/(N m) or m/N].
        stiffening: so many times stiffer above the transition torque (step, hinge), or at `largest_load` (cubic).
        transition_torque: least and greatest [N m or N].
        largest_load: that the cubic law is told by [N m or N].
    """

    compliance: Range
    stiffening: float = 1.0
    transition_torque: Range | None = None
    largest_load: float | None = None


@dataclass(frozen=True)
class Actual:
    """The actual robots: the nominal one with errors, drawn for each repeat.

    Attributes:
        geometry_error: standard deviations of the errors of lengths [m] and of angles [rad].
        springs: by element.
    """

    geometry_error: tuple[float, float] = (0.0, 0.0)
    springs: Mapping[str, Spring] = field(default_factory=dict)


@dataclass(frozen=True)
class Setting:
    """One point of a grid; SI.

    Attributes:
        poses: how many are fitted.
        selection: "random", or "planned" as `plan` does.
        kinds: what is measured, "position,orientation".
        noise, noise_angle: of the instrument [m, rad].
        outliers: fraction of the rows that are off by `outlier_size` [m].
        payload: "none", or a name of the robot's, or several with commas, which poses are shared out among.
        law: of the actual robot's springs; "rigid" for none.
        model: what is fitted, one of MODELS; "actual" for the law.
        transition: "exact", "ga", or "true" for the actual robot's transition torques.
        identify, fix: patterns with ; between them; "" for none.
        transmission, loss, prior, non_negative, bootstrap: of `calibrate`.
    """

    poses: int = 60
    selection: str = "random"
    kinds: str = "position"
    noise: float = 3e-5
    noise_angle: float = 1e-4
    outliers: float = 0.0
    outlier_size: float = 5e-3
    payload: str = "none"
    law: str = "rigid"
    model: str = "actual"
    transition: str = "exact"
    identify: str = ""
    fix: str = ""
    loss: str = "linear"
    transmission: str = "0"
    prior: bool = False
    non_negative: bool = False
    bootstrap: int = 0

    @property
    def fitted(self) -> str:
        """The law that is fitted."""
        return self.law if self.model == "actual" else self.model


@dataclass(frozen=True)
class Study:
    """A study.

    Attributes:
        robot: nominal.
        actual: how actual robots are drawn.
        settings: the points of the grid, each calibrated `repeats` times.
        varied: the names of what the grid varies.
        seed: of all chance. A repeat has the same robot, poses and directions of noise at all points of the grid.
        held_out: how many poses, measured without noise, an identified robot is judged by.
        measures: of MEASURES.
    """

    name: str
    robot: Robot
    actual: Actual
    settings: tuple[Setting, ...]
    varied: tuple[str, ...]
    repeats: int
    seed: int = 0
    held_out: int = 200
    measures: tuple[str, ...] = ()

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that give way."""
        return tuple(self.actual.springs)

    @property
    def identity(self) -> dict[str, Any]:
        """What a calibration depends on beside its setting and its repeat: another is another study."""
        drawing = robot_to_toml(self.robot)
        found = {
            "robot": hashlib.sha256(drawing.encode()).hexdigest(),
            "actual": asdict(self.actual),
            "seed": self.seed,
            "held_out": self.held_out,
            "measures": sorted(self.measures),
            "version": version("elastocal"),
        }
        return dict(json.loads(json.dumps(found)))


def cell_key(setting: Setting) -> str:
    """A short name of a point of a grid: the same for the same point, whatever else the grid has."""
    return hashlib.sha256(json.dumps(asdict(setting), sort_keys=True).encode()).hexdigest()[:12]
