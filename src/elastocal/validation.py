"""Validation: a robot's errors on measurements that it was not fitted to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.errors import InputError, unknown_name
from elastocal.identification import Residuals, Statistics, choose_gauge, fit_frames, residuals, statistics
from elastocal.measurements import Labels, Measurements
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.repeatability import Repeatability, repeatability
from elastocal.robot import Robot


@dataclass(frozen=True)
class ValidationResult:
    """Errors of a robot on data.

    Attributes:
        robot: with its frames as they were used.
        statistics: over all rows.
        parts: the same by file, station, target and payload, where there are several.
        fitted_frames: parameters of frames that had to be, or were asked to be, fitted to these data first.
        residuals: row by row.
        data: the rows.
        verdict: one sentence.
        warnings: sentences with a remedy.
        repeatability: of "position" and "orientation", where poses were measured more than once.
    """

    robot: Robot
    statistics: Statistics
    parts: Mapping[str, Statistics]
    fitted_frames: tuple[str, ...]
    residuals: Residuals
    data: Measurements
    verdict: str
    warnings: tuple[str, ...]
    repeatability: Mapping[str, Repeatability] = field(default_factory=dict)

    def __str__(self) -> str:
        """The verdict table, in millimetres."""
        lines = [f"{'position error [mm]':24}{'rows':>8}{'mean':>10}{'max':>10}{'rms':>10}"]
        for name, found in {self.robot.name: self.statistics, **self.parts}.items():
            numbers = "".join(f"{1e3 * value:10.4f}" for value in (found.mean, found.max, found.rms))
            lines.append(f"{name:24}{found.n:8d}{numbers}")
        return "\n".join([*lines, self.verdict])


def validate(robot: Robot, data: Measurements, *, refit: Sequence[str] = ()) -> ValidationResult:
    """Compare a robot, nominal or calibrated, with measurements.

    Frames that the robot leaves open are fitted to the data first, and so are those named in `refit`.

    Args:
        robot: as it is.
        data: measurements that it was not fitted to.
        refit: "base", "tool", "station.NAME" or "target.NAME": where the instrument or the probe was moved.

    Raises:
        InputError: `refit` names no frame of the robot.
        EquilibriumError: the robot does not settle under its load.
    """
    faults = [f"--refit: {unknown_name('frame', name, robot.frames)}" for name in refit if name not in robot.frames]
    if faults:
        raise InputError(*faults)
    opened = robot.with_frames({name: replace(robot.frames[name], known=False) for name in refit})
    names = [n for n, p in parameters_of(opened).items() if p.open and p.group in FRAME_GROUPS]
    fitted: tuple[str, ...] = ()
    if names:
        gauge = choose_gauge(opened, data, names)
        opened, fitted = fit_frames(opened, data, gauge), gauge.kept
    found = residuals(opened, data)
    total = statistics(found)
    warnings = []
    if fitted:
        frames = ", ".join(dict.fromkeys(name.rpartition(".")[0] for name in fitted))
        warnings.append(
            f"{frames} fitted to these data ({len(fitted)} parameters), which makes the errors smaller than they are: "
            "keep the frames of the calibration (known = true) to see all of them"
        )
    return ValidationResult(
        robot=opened,
        statistics=total,
        parts=_parts(found, data),
        fitted_frames=fitted,
        residuals=found,
        data=data,
        verdict=f"{robot.name}: {_told(total)}",
        warnings=tuple(warnings),
        repeatability=_repeatability(found, data),
    )


def _repeatability(found: Residuals, data: Measurements) -> dict[str, Repeatability]:
    kinds = {"position": found.position, "orientation": found.orientation}
    told = {kind: repeatability(data, errors) for kind, errors in kinds.items() if errors is not None}
    return {kind: judged for kind, judged in told.items() if judged is not None}


def _told(total: Statistics) -> str:
    found, unit = (total, "mm") if total.n or not total.angle else (total.angle, "mrad")
    return f"{1e3 * found.mean:.3g} {unit} mean and {1e3 * found.max:.3g} {unit} at most on {found.n} rows."


def _parts(found: Residuals, data: Measurements) -> dict[str, Statistics]:
    parts = {}
    for kind in ("source", "station", "target", "load"):
        labels: Labels | None = getattr(data, kind)
        codes = [] if labels is None else [int(code) for code in np.unique(labels.codes)]
        if labels is not None and len(codes) > 1:
            for code in codes:
                name = labels.name(code) or "none"
                parts[name if kind == "source" else f"{kind} {name}"] = statistics(found, labels.codes == code)
    return parts
