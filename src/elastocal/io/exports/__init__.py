"""The identified robot for other software: one file per format, and what each leaves of the robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from elastocal.conversion import LONGEST, Residual, nominal_geometry, residuals_left
from elastocal.errors import InputError, unknown_name
from elastocal.io.exports.corrections import corrections_csv
from elastocal.io.exports.dh import dh_csv, mdh_csv
from elastocal.io.exports.exported import Draft, Exported, Request
from elastocal.io.exports.ur_yaml import ur_yaml
from elastocal.io.exports.urdf import urdf
from elastocal.io.result_files import load_result
from elastocal.robot import Robot
from elastocal.simulation import random_poses

__all__ = ["EXPORTS", "Exported", "Residual", "export_robot", "nominal_of"]

POSES, FITTED = 1000, 300
"""Random poses at which the residual is computed; others at which frames, and what a table lacks, are fitted."""


class Export(NamedTuple):
    """A format: what it is, in a few words, and how a robot is written in it."""

    summary: str
    write: Callable[[Request], Draft]


EXPORTS = {
    "urdf": Export("URDF, with the whole robot in an element that others ignore", urdf),
    "dh-csv": Export("standard Denavit-Hartenberg table", dh_csv),
    "mdh-csv": Export("modified Denavit-Hartenberg table (Craig)", mdh_csv),
    "ur-yaml": Export("kinematics file of Universal Robots' ROS packages", ur_yaml),
    "corrections-csv": Export("corrections of each joint, for controllers", corrections_csv),
}
"""The formats, by name."""


def export_robot(
    robot: Robot, to: str, *, nominal: Robot | None = None, longest: float = LONGEST, seed: int = 0
) -> Exported:
    """Write a robot for other software, and tell what the format leaves of it.

    Args:
        robot: identified; frames without a value count as none.
        to: a key of EXPORTS.
        nominal: as the controller has it; only "corrections-csv" needs it.
        longest: of the tables: how far away along an axis a common normal may lie [m]; beyond, axes count as parallel.
        seed: of the random poses, within the joint limits, at which the residual is computed.

    Raises:
        InputError: there is no such format, or it has no place for this kind of robot.
        EquilibriumError: the robot does not settle under its load.
    """
    if to not in EXPORTS:
        raise InputError(f"--to: {unknown_name('format', to, EXPORTS)}")
    rng = np.random.default_rng(seed)
    q, q_fit = random_poses(robot, POSES, rng), random_poses(robot, FITTED, rng)
    draft = EXPORTS[to].write(Request(robot, nominal, q_fit, longest))
    residuals = residuals_left(robot, draft.readings, q, q_fit)
    text = draft.text if draft.comment is None else _commented(draft, residuals)
    return Exported(robot.name, to, text, draft.cannot_hold, draft.notes, residuals)


def nominal_of(path: Path, identified: Robot) -> Robot | None:
    """The nominal robot of an identified one, from the result.json beside its file; None where there is none.

    Raises:
        InputError: the result.json beside it belongs to another robot.
    """
    if path.suffix.lower() != ".toml" or not (path.parent / "result.json").is_file():
        return None
    return nominal_geometry(identified, load_result(path.parent, path.name).parameters)


def _commented(draft: Draft, residuals: tuple[Residual, ...]) -> str:
    """The text with what it cannot hold, and what that leaves, as comments."""
    lines = [f"Cannot hold: {text}" for text in draft.cannot_hold]
    lines += [told(residual) for residual in residuals]
    if draft.comment == "{}\n":
        return "".join(f"# {line}\n" for line in lines) + draft.text
    head, body = draft.text.split("\n", 1)
    safe = "\n".join(lines).replace("--", "- -")
    return f"{head}\n{(draft.comment or '').format(safe)}{body}"


def told(residual: Residual) -> str:
    """A residual as a sentence."""
    load = f"with payload {residual.load}" if residual.load else "without payload"
    fitted = ", base and tool fitted" if residual.refitted else ""
    position, angle = 1e3 * residual.position, 1e3 * residual.angle
    return (
        f"Residual of the tool's pose, {residual.reading}, {load}{fitted}: mean {position.mean():.4f} mm, "
        f"max {position.max():.4f} mm; mean {angle.mean():.4f} mrad, max {angle.max():.4f} mrad"
    )
