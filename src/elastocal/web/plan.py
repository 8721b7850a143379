"""What a run would do with its files and settings: what is identified, what cannot be, and the command that does it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from elastocal.errors import InputError
from elastocal.identification import choose_gauge
from elastocal.identification.request import requested, with_laws
from elastocal.web.command import arguments, command_line, fixed
from elastocal.web.inputs import Inputs
from elastocal.web.settings import Settings
from elastocal.web.study import usual_holdout

OUTPUT = "../result"
"""Where the command writes, from the folder of its inputs."""


@dataclass(frozen=True)
class Plan:
    """What a run would do.

    Attributes:
        faults: of the settings.
        kept: how many parameters are identified.
        dropped: names of those that cannot be, and why.
        arguments: of the command; None where there are faults.
        line: the command as one types it.
        prior: whether all geometry is identified about its nominal values.
    """

    faults: tuple[str, ...] = ()
    kept: int = 0
    dropped: Mapping[str, str] | None = None
    arguments: tuple[str, ...] | None = None
    line: str = ""
    prior: bool = False


def resolved(settings: Settings, inputs: Inputs) -> Settings:
    """The settings with what the user has not chosen as suggested; only joints that the robot has."""
    suggested = {j.name: "linear" if j.worth else "rigid" for j in inputs.study.joints} if inputs.study else {}
    laws = {name: (settings.laws or {}).get(name, law) for name, law in suggested.items()}
    holdout = settings.holdout
    if holdout is None:
        holdout = usual_holdout(len(inputs.fit) if inputs.fit else 0, len(inputs.held_out) if inputs.held_out else 0)
    return replace(settings, laws=laws, holdout=holdout)


def plan(settings: Settings, inputs: Inputs) -> Plan:
    """What a run would do; the settings as `resolved` gives them.

    Raises:
        InputError: the files do not allow a calibration.
    """
    robot, fit = inputs.robot, inputs.fit
    if robot is None or fit is None or not inputs.sound:
        raise InputError("expected a robot file and measurements without faults")
    given = arguments(settings, robot, inputs.named("robot")[0], inputs.named("fit"), inputs.named("held_out"), OUTPUT)
    try:
        wished, springs = with_laws(robot, settings.elastic)
        gauge = choose_gauge(wished, fit, requested(wished, springs, settings.identify or None, fixed(robot, settings)))
    except InputError as error:
        return Plan(faults=error.faults)
    dropped = {name: found.reason for name, found in gauge.dropped.items()}
    shown = [*given[:-1], "result"]
    return Plan((), len(gauge.kept), dropped, tuple(given), command_line(shown), settings.prior)
