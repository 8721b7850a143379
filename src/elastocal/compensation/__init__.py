"""Compensation: inverse kinematics of any chain, and of the robot that bends."""

from elastocal.compensation.advice import Asked, Calibrated, tcp_warnings
from elastocal.compensation.outcome import Compensation, Rows, Spread, Summary
from elastocal.compensation.run import BLOCK, Job, compensate, compensated, inverse_kinematics
from elastocal.compensation.targets import NO_NOMINAL, Targets, require_targets
from elastocal.compensation.words import verdict

__all__ = [
    "BLOCK",
    "NO_NOMINAL",
    "Asked",
    "Calibrated",
    "Compensation",
    "Job",
    "Rows",
    "Spread",
    "Summary",
    "Targets",
    "compensate",
    "compensated",
    "inverse_kinematics",
    "require_targets",
    "tcp_warnings",
    "verdict",
]
