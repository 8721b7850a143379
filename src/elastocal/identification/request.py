"""What a user asks to be identified: names and patterns into parameters and laws."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

from elastocal.elasticity import LAWS
from elastocal.errors import InputError, unknown_name
from elastocal.parameters import FRAME_GROUPS, Group, parameters_of
from elastocal.robot import Compliance, Robot


def with_laws(robot: Robot, elastic: Mapping[str, str]) -> tuple[Robot, tuple[str, ...]]:
    """The robot with laws on elements, and these elements' names: "2" is the one that joint 2 drives.

    An element that already has the law keeps its coefficients as a first guess; otherwise they are zero.

    Raises:
        InputError: an element or a law that does not exist.
    """
    joints = {row.name: row.joint_element for row in robot.joints}
    faults, laws = [], {}
    for asked, law in elastic.items():
        name = joints.get(asked, asked)
        if name in laws:
            faults.append(f"element {name} is named twice, also as {asked!r}: name it once")
        elif name not in robot.compliant_elements:
            faults.append(unknown_name("element", asked, [*joints, *robot.compliant_elements]))
        elif law not in LAWS:
            faults.append(f"element {asked}: {unknown_name('law', law, LAWS)}")
        else:
            known = robot.elastic.get(name)
            laws[name] = known if known and known.law == law else Compliance.rigid(law)
    if faults:
        raise InputError(*faults)
    return replace(robot, elastic={**robot.elastic, **laws}), tuple(laws)


def requested(
    robot: Robot, elastic: Iterable[str], identify: Sequence[str] | None = None, fix: Sequence[str] = ()
) -> tuple[str, ...]:
    """Names of the parameters asked for: open frames, the rows' geometry or what `identify` matches, and compliances.

    Args:
        robot: with the laws on it.
        elastic: elements whose coefficients are asked for.
        identify: patterns of names, "*.theta"; None: all geometry.
        fix: patterns of names that stay as they are.

    Raises:
        InputError: a pattern that matches no parameter.
    """
    parameters = parameters_of(robot)
    faults = [
        f"{option} {unknown_name('parameter matches', pattern, parameters)}"
        for option, patterns in (("--identify", identify or ()), ("--fix", fix))
        for pattern in patterns
        if not any(fnmatchcase(name, pattern) for name in parameters)
    ]
    faults += [
        f"{option} {pattern}: transition torques are searched for; give them with --transition to hold them"
        for option, patterns in (("--identify", identify or ()), ("--fix", fix))
        for pattern in patterns
        if {p.group for name, p in parameters.items() if fnmatchcase(name, pattern)} == {Group.TRANSITION}
    ]
    if faults:
        raise InputError(*faults)
    compliances = {f"{element}.{name}" for element in elastic for name in LAWS[robot.elastic[element].law].coefficients}
    chosen = []
    for name, parameter in parameters.items():
        if identify is None:
            wanted = parameter.open
        else:
            matched = any(fnmatchcase(name, pattern) for pattern in identify)
            wanted = matched or (parameter.open and parameter.group in FRAME_GROUPS)
        if parameter.group == Group.TRANSITION:
            continue  # searched for, not stepped along
        if (wanted or name in compliances) and not any(fnmatchcase(name, pattern) for pattern in fix):
            chosen.append(name)
    return tuple(chosen)
