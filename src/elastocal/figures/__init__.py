"""Figures of a calibration, for notebooks and scripts: each takes a result and returns a plotly figure.

    import elastocal as ec
    ec.figures.torque_deflection(result).show()

A result is what `calibrate` returned or `load_result` read. A figure of which the result has nothing, as of joint maps
that were not asked for, raises InputError.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from elastocal.errors import InputError
from elastocal.figures import accuracy, compliance, errors, maps, parameters, residuals
from elastocal.figures.panel import Panel, figure
from elastocal.figures.rows import rows_of
from elastocal.identification import AnyResult

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

__all__ = [
    "accuracy_map",
    "correlation",
    "error_vectors",
    "joint_maps",
    "parameter_deviations",
    "position_errors",
    "residuals_by_joint",
    "residuals_by_torque",
    "singular_values",
    "torque_deflection",
    "transition_search",
]


def position_errors(result: AnyResult) -> Figure:
    """Errors before and after [mm], and of orientations [mrad], as histograms and cumulative curves.

    Raises:
        InputError: the result was loaded from a folder without residuals.csv.
    """
    return _drawn(errors.error_panels(_with_rows(result)), "errors")


def error_vectors(result: AnyResult) -> Figure:
    """Error vectors at the measured points, before and after, and the robot, in the base's frame [m].

    Errors of distances are drawn along the line of sight.

    Raises:
        InputError: there are no rows, or nothing but orientations was measured.
    """
    found = _with_rows(result)
    return _drawn(errors.vector_panels(found, rows_of(found)), "error vectors: no position or distance was measured")


def residuals_by_joint(result: AnyResult, joint: str | None = None) -> Figure:
    """What the model leaves, as a motion of one joint alone [µrad or µm], against the joint's position [deg or mm].

    What follows it, as waves, is an error of the drive that joint maps would take away.

    Args:
        result: of a calibration.
        joint: the name of its row, as "2"; None: all joints.

    Raises:
        InputError: there are no rows, or no such joint.
    """
    found = _with_rows(result)
    return _drawn(_chosen(residuals.joint_panels(found, rows_of(found)), joint), "residuals by joint")


def residuals_by_torque(result: AnyResult, joint: str | None = None) -> Figure:
    """The same against the torque [N m] or force [N] on the joint: what follows it is compliance not yet modelled.

    Args:
        result: of a calibration.
        joint: the name of its row, as "2"; None: all joints that carry a load.

    Raises:
        InputError: there are no rows, or no such joint that carries a load.
    """
    found = _with_rows(result)
    return _drawn(
        _chosen(residuals.torque_panels(found, rows_of(found)), joint), "residuals by torque: no joint carries a load"
    )


def torque_deflection(result: AnyResult, element: str | None = None) -> Figure:
    """Torque [N m] against deflection [µrad] of elastic elements (N and µm of sliding ones).

    The identified law with its 95 % band, the rows' partial residuals (the law's deflection and what is left, as a
    motion of this element alone), their means, and the transition torque with its 95 % interval.

    Args:
        result: of a calibration with compliance.
        element: "2" for the one that joint 2 drives, or its full name, as "2.theta"; None: all of them.

    Raises:
        InputError: there are no rows, no elastic elements, or no such one.
    """
    found = _with_rows(result)
    return _drawn(_chosen(compliance.law_panels(found, rows_of(found)), element), "compliance: nothing was elastic")


def joint_maps(result: AnyResult, joint: str | None = None) -> Figure:
    """Transmission error [µrad] against joint position [deg], with its 95 % band and where it was measured.

    Args:
        result: of a calibration with joint maps.
        joint: the name of its row, as "2"; None: all joints.

    Raises:
        InputError: there are no rows, no joint maps, or no such joint.
    """
    found = _with_rows(result)
    return _drawn(
        _chosen(maps.map_panels(found, rows_of(found)), joint), "joint maps: none were asked for (transmission)"
    )


def transition_search(result: AnyResult) -> Figure:
    """How much worse other transition torques fit, in standard deviations (the root of the rise of chi-square).

    Each torque with all else at its best beside it; of two torques a map too; of a genetic algorithm its generations.

    Raises:
        InputError: no transition torque was searched.
    """
    return _drawn(compliance.search_panels(result), "the search: no transition torque was searched")


def parameter_deviations(result: AnyResult) -> Figure:
    """Identified less nominal geometry, with two standard deviations.

    In units of the robot's tolerances, or of those that a fit with priors estimated; where there are none in mm and
    mrad.

    Raises:
        InputError: no geometry was identified.
    """
    return _drawn(parameters.deviation_panels(result), "deviations: no geometry was identified")


def correlation(result: AnyResult) -> Figure:
    """Correlation matrix of the identified parameters' errors, coefficients of joint maps left out.

    Raises:
        InputError: fewer than two parameters were identified.
    """
    return _drawn(parameters.correlation_panels(result), "correlations: fewer than two parameters were identified")


def singular_values(result: AnyResult) -> Figure:
    """Singular values of the identification Jacobian, in metres per metre.

    Raises:
        InputError: the result was saved by a version that did not keep them.
    """
    return _drawn(parameters.singular_panels(result), "singular values: calibrate anew to have them")


def accuracy_map(result: AnyResult, poses: int | None = None, seed: int = 0) -> Figure:
    """Standard deviation of the predicted position [mm] over the workspace, from the side and from above.

    The median of random poses within the joint limits, with the target, station and payload measured most.

    Args:
        result: of a calibration.
        poses: how many random poses; 4000 if left out, 1500 with joint maps.
        seed: of these.

    Raises:
        InputError: there are no rows.
        EquilibriumError: a pose does not settle under its load.
    """
    found = _with_rows(result)
    uncertainty = accuracy.workspace_uncertainty(found, poses, seed)
    return _drawn(accuracy.accuracy_panels(found, rows_of(found), uncertainty), "accuracy")


def _with_rows(result: AnyResult) -> AnyResult:
    if result.errors is None:
        raise InputError("the result has no rows: there is no residuals.csv in its folder")
    return result


def _drawn(panels: Sequence[Panel], what: str) -> Figure:
    if not panels:
        raise InputError(f"there is nothing to draw of {what}")
    return figure(panels)


def _chosen(panels: Sequence[Panel], name: str | None) -> list[Panel]:
    """The panel of an element, or of the joint of a row; all for None."""
    chosen = [panel for panel in panels if name in (None, panel.title, panel.title.rpartition(".")[0])]
    if panels and not chosen:
        raise InputError(f"{name!r}: expected one of {', '.join(panel.title for panel in panels)}")
    return chosen
