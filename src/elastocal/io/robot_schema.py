"""The robot file's schema: plain dataclasses that pydantic checks, in the units of the file."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)]
Triple = tuple[Number, Number, Number]

STRICT = ConfigDict(extra="forbid")


@dataclass(config=STRICT)
class FrameEntry:
    """[base], [station.*] and [target.*]."""

    xyz: Triple | None = None
    rpy: Triple | None = None
    known: bool = False


@dataclass(config=STRICT)
class ToolEntry(FrameEntry):
    """[tool]."""

    mass: NotNegative = 0.0
    com: Triple = (0.0, 0.0, 0.0)


@dataclass(config=STRICT)
class LoadEntry:
    """[load.*]."""

    mass: NotNegative = 0.0
    com: Triple = (0.0, 0.0, 0.0)


@dataclass(config=STRICT)
class RowEntry:
    """[[row]]."""

    name: Annotated[str, Field(min_length=1, coerce_numbers_to_str=True)]
    alpha: Number = 0.0
    a: Number = 0.0
    beta: Number = 0.0
    b: Number = 0.0
    theta: Number = 0.0
    d: Number = 0.0
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    axis: Triple = (0.0, 0.0, 1.0)
    joint: Literal["revolute", "prismatic"] | None = None
    sign: Literal[1, -1] = 1
    limits: tuple[Number, Number] | None = None
    mass: NotNegative = 0.0
    com: Triple = (0.0, 0.0, 0.0)
    stiffness: Positive | None = None


@dataclass(config=STRICT)
class CouplingEntry:
    """[coupling]."""

    matrix: list[list[Number]]


@dataclass(config=STRICT)
class ElasticEntry:
    """[elastic."2.theta"], SI."""

    law: str
    coefficients: list[Number]
    transition_torque: Positive | None = None


@dataclass(config=STRICT)
class TransmissionEntry:
    """[transmission."2.theta"]."""

    sin: list[Number] = field(default_factory=list)
    cos: list[Number] = field(default_factory=list)


@dataclass(config=STRICT)
class RobotEntry:
    """The whole file."""

    format: Literal["elastocal-robot/1"]
    convention: Literal["modified-dh", "standard-dh", "urdf"]
    row: Annotated[list[RowEntry], Field(min_length=1)]
    name: str = "robot"
    length_unit: Literal["m", "mm"] = "m"
    angle_unit: Literal["rad", "deg"] = "rad"
    gravity: Triple = (0.0, 0.0, -9.81)
    base: FrameEntry = field(default_factory=FrameEntry)
    tool: ToolEntry = field(default_factory=ToolEntry)
    target: dict[str, FrameEntry] = field(default_factory=dict)
    load: dict[str, LoadEntry] = field(default_factory=dict)
    coupling: CouplingEntry | None = None
    elastic: dict[str, ElasticEntry] = field(default_factory=dict)
    transmission: dict[str, TransmissionEntry] = field(default_factory=dict)
    station: dict[str, FrameEntry] = field(default_factory=dict)
