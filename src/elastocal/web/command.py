"""Settings as the arguments of `elastocal calibrate`."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence

from elastocal.parameters import FRAME_GROUPS, Group, Parameter, parameters_of
from elastocal.robot import Robot
from elastocal.web.settings import Settings

SEARCHED = ("step", "hinge")
"""Laws with a transition torque."""


def arguments(
    settings: Settings, robot: Robot, robot_file: str, data: Sequence[str], held_out: Sequence[str], output: str
) -> list[str]:
    """Arguments after `elastocal`, nothing in them that is as it would be without."""
    given = ["calibrate", robot_file, *data]
    given += ["--tip", settings.tip] if settings.tip else []
    if held_out:
        given += ["--held-out", *held_out]
    elif settings.holdout:
        given += ["--holdout", f"{settings.holdout:g}"]
    given += ["--identify", *settings.identify] if settings.identify else []
    kept = fixed(robot, settings)
    given += ["--fix", *kept] if kept else []
    given += [*_elastic(settings), *_others(settings), "-o", output]
    return given


def command_line(given: Sequence[str]) -> str:
    """The command as one types it."""
    return shlex.join(["elastocal", *given])


def fixed(robot: Robot, settings: Settings) -> list[str]:
    """Patterns of parameters that stay as they are."""
    return [*_fixed_groups(robot, settings), *settings.fix]


def _elastic(settings: Settings) -> Iterator[str]:
    """Laws, and how transition torques are found."""
    if not settings.elastic:
        return
    yield "--elastic"
    yield ",".join(name if law == "linear" else f"{name}:{law}" for name, law in settings.elastic.items())
    if any(law in SEARCHED for law in settings.elastic.values()):
        if settings.transition == "given":
            yield from ("--transition", settings.torques.replace(" ", ""))
        elif settings.transition == "ga":
            yield from ("--transition", "ga", "--population", str(settings.population))
            yield from ("--generations", str(settings.generations))
    if settings.non_negative:
        yield "--non-negative"


def _others(settings: Settings) -> Iterator[str]:
    if settings.loss != "linear":
        yield from ("--loss", settings.loss)
    if settings.maps != "none":
        yield from ("--transmission", "auto" if settings.maps == "auto" else str(settings.orders))
    if settings.prior:
        yield "--prior"
    if settings.bootstrap:
        yield from ("--bootstrap", str(settings.bootstrap))
    if settings.seed:
        yield from ("--seed", str(settings.seed))


def _fixed_groups(robot: Robot, settings: Settings) -> list[str]:
    """Patterns of the geometry that stays as it is: those that match nothing else, or names."""
    if settings.identify:
        return []
    parameters = parameters_of(robot)
    left = {name for name, p in parameters.items() if group_of(p) not in (None, *settings.groups)}
    patterns, rest = [], dict.fromkeys(left)
    for key in dict.fromkeys(name.rpartition(".")[2] for name in parameters if name in left):
        matched = {name for name in parameters if name.endswith(f".{key}")}
        if matched <= left:
            patterns.append(f"*.{key}")
            for name in matched:
                rest.pop(name, None)
    return patterns + [name for name in parameters if name in rest]


def group_of(parameter: Parameter) -> str | None:
    """The group of geometry, of GROUPS, that a parameter belongs to; None of frames and compliances."""
    if parameter.group in FRAME_GROUPS or parameter.group >= Group.COMPLIANCE:
        return None
    if parameter.group == Group.OFFSET:
        return "offsets"
    return "lengths" if parameter.unit == "m" else "angles"
