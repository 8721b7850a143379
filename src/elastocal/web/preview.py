"""The robot at each measured pose, as lines to be drawn, and the measured points, in its base frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.chain import Array, Chain, forward, place, points
from elastocal.figures.style import BEFORE, DARK, JOINT, LIGHT, LINK, ON_DARK, UNSEEN
from elastocal.measurements import Combination, Measurements
from elastocal.robot import Assembly, Robot, assemble


def preview(robot: Robot, data: Measurements, errors: Array | None) -> dict[str, Any]:
    """What the page draws; lengths in whole 0.1 mm, to keep it short.

    Args:
        robot: nominal, its frames where they were found.
        data: what was measured.
        errors: (n,) distances of the robot from the measured points [m].

    Returns:
        "poses": by row, the corners of the robot's line from base to target, flat; "joints": which corners are joints;
        "points": by row, the measured point or None; "errors" [mm]; "names" of the rows; "q" [deg or mm]; and how all
        this looks.
    """
    n = len(data)
    lines: list[list[int]] = [[] for _ in range(n)]
    joints: list[list[int]] = [[] for _ in range(n)]
    measured = np.full((n, 3), np.nan)
    for found in data.combinations:
        line, knots, rotation, origin = _line(robot, data, found)
        flat = _short(line.reshape(len(found.rows), -1)).tolist()
        for row, corners in zip(found.rows.tolist(), flat, strict=True):
            lines[row], joints[row] = corners, knots
        if data.position is not None:
            measured[found.rows] = (data.position[found.rows] - origin) @ rotation
    return {
        "poses": lines,
        "joints": joints[0] if all(knots == joints[0] for knots in joints) else joints,
        "points": [None if np.isnan(p).any() else _short(p).tolist() for p in measured],
        "errors": None if errors is None else np.round(1e3 * np.nan_to_num(errors), 4).tolist(),
        "names": [data.place(row) for row in range(n)],
        "q": np.round(data.q * _scales(robot, data.q.shape[1]), 2).tolist(),
        "style": style(),
    }


def style() -> dict[str, Any]:
    """Templates and colours of the report's figures, on light and on dark pages."""
    colors = {"link": LINK, "joint": JOINT, "error": BEFORE, "here": UNSEEN}
    return {
        "light": {"template": LIGHT} | colors,
        "dark": {"template": DARK} | {name: ON_DARK[color] for name, color in colors.items()},
    }


def _scales(robot: Robot, positions: int) -> Array:
    """From SI to deg or mm, of the controller's joint positions."""
    scales = [180.0 / np.pi if row.joint == "revolute" else 1e3 for row in robot.joints]
    return np.array(scales if len(scales) == positions else [180.0 / np.pi] * positions)


def _line(robot: Robot, data: Measurements, found: Combination) -> tuple[Array, list[int], Array, Array]:
    """Corners (n, corners, 3) in the base frame, which of them are joints, and the base's rotation and origin."""
    assembly = assemble(robot, found.station, found.target, found.load)
    base = assembly.mechanism.chain.marks[0]
    chain = _with_corners(assembly)
    placement = place(chain, chain.values)
    frames = forward(placement, assembly.motion(data.q[found.rows].T))
    marked = zip(chain.mark_frames, placement.mark_origins, strict=True)
    along = np.stack([points(frames, int(frame), local) for frame, local in marked]).transpose(2, 0, 1)
    rotation, origin = placement.mark_rotations[0], placement.mark_origins[0]
    driven = [chain.index[row.joint_element] for row in robot.joints if row.joint_element]
    # the corner where a joint sits is the last one before it
    knots = [sum(base < mark <= element for mark in chain.marks) for element in driven]
    return (along - origin) @ rotation, sorted(set(knots)), rotation, origin


def _with_corners(assembly: Assembly) -> Chain:
    """The chain with a mark after its base and after each translation that has a length."""
    chain = assembly.mechanism.chain
    base = chain.marks[0]
    long = [i + 1 for i, e in enumerate(chain.elements) if not e.rotation and (e.value or i in chain.moving)]
    return Chain(chain.elements, chain.moving, (base, *(mark for mark in long if mark > base)))


def _short(lengths: Array) -> Array:
    return np.rint(1e4 * lengths).astype(int)
