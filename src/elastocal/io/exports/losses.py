"""What of a robot a format has no place for, told for what this robot has."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from elastocal.errors import InputError
from elastocal.robot import Frame, Robot

DOWN = (0.0, 0.0, -1.0)


def losses(robot: Robot, holds: Collection[str] = ()) -> tuple[str, ...]:
    """All that the robot has besides geometry and tool, but for what the format holds."""
    return tuple(text for kind, text in _features(robot) if kind not in holds)


def _features(robot: Robot) -> Iterator[tuple[str, str]]:
    named = {
        "compliance": ("compliance of", robot.elastic),
        "maps": ("joint maps of", robot.transmission),
        "limits": ("limits of joints", [row.name for row in robot.joints if row.limits]),
        "masses": ("masses of", _heavy(robot)),
        "payloads": ("payloads", robot.loads),
        "targets": ("targets", robot.targets),
    }
    yield from ((kind, f"{text} {', '.join(names)}") for kind, (text, names) in named.items() if names)
    if robot.coupling is not None:
        yield "coupling", "coupling of the joints"
    given = [name for name, frame in robot.frames.items() if name.startswith(("base", "station")) and _given(frame)]
    if given:
        yield "base", f"place before the instrument ({', '.join(given)})"
    size = math.hypot(*robot.gravity)
    if size and tuple(g / size for g in robot.gravity) != DOWN:
        x, y, z = robot.gravity
        yield "gravity", f"gravity ({x:g}, {y:g}, {z:g}) m/s² in the base frame: others take it along -z"


def _heavy(robot: Robot) -> list[str]:
    return [f"link {row.name}" for row in robot.rows if row.mass] + (["tool"] if robot.tool_load.mass else [])


def _given(frame: Frame) -> bool:
    return frame.xyz is not None or frame.rpy is not None


def tool_note(robot: Robot) -> tuple[str, ...]:
    """A sentence where the tool is not known."""
    if _given(robot.tool) or robot.tool.known:
        return ()
    return ("The tool is not known: its frame is written as the flange's.",)


def require_uncoupled(robot: Robot, to: str) -> None:
    """Check that no joint of the robot is coupled to another.

    Raises:
        InputError: the joints are coupled.
    """
    if robot.coupling is not None:
        raise InputError(
            f"--to {to}: the joints of {robot.name} are coupled, for which the format has no place: "
            "expected joints that move one row each (urdf holds couplings)"
        )
