"""What a reproduction consists of: values only."""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.identification import Statistics


@dataclass(frozen=True)
class Figures:
    """Mean and largest position error [m]."""

    mean: float
    max: float

    @classmethod
    def of(cls, found: Statistics) -> Figures:
        """Those of a calibration's residuals."""
        return cls(found.mean, found.max)


@dataclass(frozen=True)
class Chosen:
    """An input that a paper does not give: what it is, the value we chose, and why."""

    what: str
    value: str
    reason: str


@dataclass(frozen=True)
class Slip:
    """What the print of a paper says in a place, and what is meant there."""

    place: str
    printed: str
    meant: str


@dataclass(frozen=True)
class Paper:
    """A paper, what it leaves open and where its print slips."""

    key: str
    title: str
    chosen: tuple[Chosen, ...]
    slips: tuple[Slip, ...]


@dataclass(frozen=True)
class ParameterRow:
    """A parameter in the paper and here; SI.

    Attributes:
        name: "2.alpha".
        unit: in which the paper prints it: "rad", "deg" or "m".
        nominal: before.
        actual: of the simulated robot.
        paper: what the paper found; None where it does not say.
        ours: what is found here, with its standard deviation `std` (None where it was not identified).
        verdict: of the calibration.
    """

    name: str
    unit: str
    nominal: float
    actual: float
    paper: float | None
    ours: float
    std: float | None
    verdict: str


@dataclass(frozen=True)
class StiffnessRow:
    """A joint's stiffness [N m/rad] in the paper and here.

    Attributes:
        joint: its name.
        actual: of the simulated robot; None where the joint is rigid.
        paper: what the paper found; None where it does not say.
        compliance: what is found here [rad/(N m)], with its standard deviation `std` (None: not identified).
        verdict: of the calibration.
    """

    joint: str
    actual: float | None
    paper: float | None
    compliance: float
    std: float | None
    verdict: str

    @property
    def ours(self) -> float | None:
        """The inverse of the compliance, huge or negative as it may be; None for a compliance of zero."""
        return 1.0 / self.compliance if self.compliance else None
