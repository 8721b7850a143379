"""What a plan has to say: warnings with a remedy, and notes."""

from __future__ import annotations

from collections.abc import Iterator

from elastocal.design.exchange import Pool
from elastocal.design.precision import Precision, fewest
from elastocal.design.request import AVERAGED, Request
from elastocal.design.task import MEDIAN, SHARES, Task, unknown_frames
from elastocal.parameters import Group, parameters_of
from elastocal.robot import Robot

MOST_LISTED = 8


def warnings(task: Task, pool: Pool, precision: Precision, request: Request, robot: Robot) -> tuple[str, ...]:
    """What of the plan is not as asked for, and what to do about it."""
    return tuple(_warnings(task, pool, precision, request, robot))


def _warnings(task: Task, pool: Pool, precision: Precision, request: Request, robot: Robot) -> Iterator[str]:
    needed, names = fewest(pool), [n for n, u in zip(task.names, precision.unseen, strict=True) if u]
    if names and request.count < needed:
        poses = "1 pose" if request.count == 1 else f"{request.count} poses"
        yield (
            f"{poses} cannot tell {len(task.names)} parameters: it needs at least {needed}, and some more for the "
            "noise to average out; ask for more, or identify less (--identify, --fix)"
        )
    elif names:
        yield (
            f"these candidates do not tell {_listed(names)}: offer others, as with payloads or targets, or leave these "
            "out (--fix)"
        )
    parameters = parameters_of(task.robot)
    for name, dropped in task.gauge.dropped.items():
        if parameters[name].group == Group.COMPLIANCE:
            yield f"{name} cannot be identified: {dropped.reason}"
    open_frames = [n for n, f in robot.frames.items() if n.split(".")[0] in ("base", "station") and not f.known]
    if request.reading.kinds == ("distance",) and any(robot.frames[name].xyz is None for name in open_frames):
        yield (
            "what a distance tells hangs on where the instrument stands, which is not known: write a first guess of "
            "[base] into the robot file"
        )


def notes(task: Task, request: Request, robot: Robot) -> tuple[str, ...]:
    """What else there is to know."""
    return tuple(_notes(task, request, robot))


def _notes(task: Task, request: Request, robot: Robot) -> Iterator[str]:
    for element, (torque, source) in task.assumed.items():
        unit = "N·m" if element.endswith("theta") else "N"
        meanwhile = f"until then {torque:.4g} {unit} stands for it, {source}"
        if source == MEDIAN and request.criterion in AVERAGED:
            below = [f"{100 * share:.0f}" for share in sorted(SHARES)]
            meanwhile = (
                f"the poses suit torques above {', '.join(below[:-1])} and {below[-1]} % of the loads on average"
            )
        yield f"{element}: its transition torque will be searched for; {meanwhile}, and loads cover their range"
    anywhere = [name for name in unknown_frames(robot) if any(kept.startswith(f"{name}.") for kept in task.names)]
    if anywhere:
        yield (
            f"no first guess of {_listed(anywhere)}: a place is assumed, on which the standard deviations of these "
            "parameters depend"
        )
    carried = [name for name in anywhere if name.startswith(("tool", "target"))]
    if carried:
        averaged = ", and the poses suit several places on average" if request.criterion in AVERAGED else ""
        yield (
            f"it matters where the target sits on the tool{averaged}: with a first guess of {_listed(carried)} in the "
            "robot file, to a centimetre, the plan is better"
        )


def _listed(names: list[str]) -> str:
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")
