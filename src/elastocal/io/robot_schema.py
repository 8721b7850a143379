"""The robot file's schema: plain dataclasses that pydantic checks, in the units of the file."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from elastocal.io.checking import STRICT, Flag, Matrix, NotNegative, Number, Numbers, Pair, Positive, Triple


@dataclass(config=STRICT)
class FrameEntry:
    """[base], [station.*] and [target.*]."""

    xyz: Triple | None = None
    rpy: Triple | None = None
    known: Flag = False


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

    name: Annotated[str, Field(min_length=1, coerce_numbers_to_str=True), "a name in quotes"]
    alpha: Number | None = None
    a: Number | None = None
    beta: Number | None = None
    b: Number | None = None
    theta: Number | None = None
    d: Number | None = None
    xyz: Triple | None = None
    rpy: Triple | None = None
    axis: Triple | None = None
    joint: Literal["revolute", "prismatic"] | None = None
    sign: Literal[1, -1] = 1
    limits: Pair | None = None
    mass: NotNegative = 0.0
    com: Triple = (0.0, 0.0, 0.0)
    stiffness: Positive | None = None


@dataclass(config=STRICT)
class CouplingEntry:
    """[coupling]."""

    matrix: Matrix


@dataclass(config=STRICT)
class ElasticEntry:
    """[elastic."2.theta"], SI."""

    law: str
    coefficients: Numbers
    transition_torque: Positive | None = None


@dataclass(config=STRICT)
class TransmissionEntry:
    """[transmission."2.theta"]."""

    sin: Numbers = field(default_factory=list)
    cos: Numbers = field(default_factory=list)


@dataclass(config=STRICT)
class ToleranceEntry:
    """[tolerance], in the units of the file."""

    length: Positive | None = None
    angle: Positive | None = None
    offset: Positive | None = None


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
    tolerance: ToleranceEntry = field(default_factory=ToleranceEntry)
