"""Comparison of models: does what the laws of compliance explain outweigh what they cost?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np

from elastocal.chain import Array
from elastocal.cross_validation import cross_validate
from elastocal.elasticity import LAWS
from elastocal.errors import EquilibriumError, InputError, unknown_name
from elastocal.identification import CalibrationResult, Statistics, calibrate
from elastocal.identification.sums import FLOOR
from elastocal.measurements import Measurements
from elastocal.parallel import in_order
from elastocal.robot import Robot

MODELS = ("rigid", *LAWS)
"""What can be compared: no compliance at all, and one law on all named elements."""

PENALTY = 1.6
"""What a parameter costs, in units of BIC's ln(coordinates); chosen by simulation (studies/model_choice.py)."""


@dataclass(frozen=True)
class ComparedModel:
    """One model's fit.

    Attributes:
        name: of MODELS.
        status: of the calibration; "no_equilibrium" if there is none.
        parameters: how many were identified, searched transition torques included.
        coordinates: how many were observed.
        residual: of the fitted rows.
        cross_validated: of rows that the fit had not seen.
        deviance: -2 ln(likelihood), up to what is the same for all models.
        aicc, bic: criteria of Akaike (corrected for few data) and Schwarz.
        criterion: BIC with its penalty times PENALTY; the model with the least is recommended.
    """

    name: str
    status: str
    parameters: int
    coordinates: int = 0
    residual: Statistics | None = None
    cross_validated: Statistics | None = None
    deviance: float = np.inf
    aicc: float = np.inf
    bic: float = np.inf
    criterion: float = np.inf


@dataclass(frozen=True)
class Comparison:
    """Models side by side.

    Attributes:
        robot: its name.
        elements: that the laws were tried on, as asked for.
        models: in the order asked for.
        recommended: the name of one of them; None if none converged.
        verdict: one sentence.
        warnings: sentences with a remedy.
    """

    robot: str
    elements: tuple[str, ...]
    models: tuple[ComparedModel, ...]
    recommended: str | None
    verdict: str
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        """The models and their figures, in millimetres."""
        lines = [f"{'model':10}{'parameters':>12}{'residual':>12}{'unseen':>12}{'criterion':>12}"]
        for m in self.models:
            errors = [np.nan if s is None else 1e3 * s.mean for s in (m.residual, m.cross_validated)]
            lines.append(f"{m.name:10}{m.parameters:12d}{errors[0]:12.4f}{errors[1]:12.4f}{m.criterion:12.1f}")
        return "\n".join([*lines, self.verdict])


def compare(
    robot: Robot,
    data: Measurements,
    *,
    elastic: Sequence[str],
    models: Sequence[str] = MODELS,
    folds: int | None = 10,
    identify: Sequence[str] | None = None,
    fix: Sequence[str] = (),
    seed: int = 0,
    on_fit: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> Comparison:
    """Fit models of compliance to the same data and recommend one.

    Args:
        robot: nominal.
        data: what was measured.
        elastic: elements that the laws are tried on: "2" for the element that joint 2 drives, "2.alpha", ….
        models: of MODELS.
        folds: of the cross-validation; None: without.
        identify: patterns of parameter names, as in `calibrate`.
        fix: patterns of parameter names, as in `calibrate`.
        seed: of the division into folds.
        on_fit: called with the number of calibrations done and of all.
        executor: where they run; None: here, one after the other. The result is the same.

    Raises:
        InputError: names that do not exist, or no element at all.
    """
    faults = [unknown_name("model", name, MODELS) for name in models if name not in MODELS]
    if not elastic:
        faults.append("elastic: expected at least one element, as 2,3")
    if faults:
        raise InputError(*faults)
    models = tuple(dict.fromkeys(models))
    fits = {
        name: partial(calibrate, robot, identify=identify, fix=fix, elastic=_laws(name, elastic)) for name in models
    }
    done, total = 0, len(models) * (1 + (folds or 0))

    def count(*_: int) -> None:
        nonlocal done
        done += 1
        if on_fit is not None:
            on_fit(done, total)

    results = []
    for result in in_order(partial(_fitted, data), list(fits.values()), executor, chunk=1):
        results.append(result)
        count()
    compared = []
    for (name, fit), result in zip(fits.items(), results, strict=True):
        if result is None:
            compared.append(ComparedModel(name, "no_equilibrium", 0))
            continue
        unseen = None
        if folds is not None:
            unseen = cross_validate(partial(_robot_of, fit), data, folds, seed, on_fold=count, executor=executor)
        compared.append(_judged(name, result, unseen))
    return _concluded(robot, tuple(elastic), tuple(compared))


def _laws(model: str, elements: Sequence[str]) -> dict[str, str]:
    return {} if model == "rigid" else dict.fromkeys(elements, model)


Fit = Callable[[Measurements], CalibrationResult]


def _fitted(data: Measurements, fit: Fit) -> CalibrationResult | None:
    """A model's calibration; None if the robot does not settle."""
    try:
        return fit(data)
    except EquilibriumError:
        return None


def _robot_of(fit: Fit, data: Measurements) -> Robot:
    return fit(data).robot


def _judged(name: str, result: CalibrationResult, unseen: Statistics | None) -> ComparedModel:
    """A model's criteria."""
    steps = [e for e in result.elastic if e.law == "step" and e.transition is not None and e.transition.searched]
    parameters = len(result.names) + len(steps)
    n, deviance = result.coordinates, _deviance(result)
    spare = n - parameters - 1
    return ComparedModel(
        name=name,
        status=result.status,
        parameters=parameters,
        coordinates=n,
        residual=result.residuals["calibrated"],
        cross_validated=unseen,
        deviance=deviance,
        aicc=deviance + 2.0 * parameters * n / spare if spare > 0 else np.inf,
        bic=deviance + parameters * np.log(n),
        criterion=deviance + PENALTY * parameters * np.log(n),
    )


def _deviance(result: CalibrationResult) -> float:
    """-2 ln(likelihood) of normal residuals with the variances that fit best, less the constant."""
    data, found, fitted = result.errors.data, result.errors.calibrated, ~result.errors.held_out
    stated = {"position": data.sigma, "orientation": data.sigma_angle, "distance": data.sigma}
    total = 0.0
    for kind, sigma in stated.items():
        residual: Array | None = getattr(found, kind)
        if residual is None:
            continue
        residual = residual[fitted].reshape(int(fitted.sum()), -1)
        seen = np.isfinite(residual)
        if sigma is None:
            variance = np.full(residual.shape, np.mean(residual[seen] ** 2))
        else:
            own = np.nan_to_num(sigma[fitted].reshape(len(residual), -1)[:, : residual.shape[1]])
            variance = np.broadcast_to(own**2 + result.model_sigma[kind] ** 2, residual.shape)
        variance = np.maximum(variance[seen], FLOOR)
        total += float((np.log(variance) + residual[seen] ** 2 / variance).sum())
    return total


def _concluded(robot: Robot, elements: tuple[str, ...], models: tuple[ComparedModel, ...]) -> Comparison:
    """The recommendation, and what speaks against it."""
    sound = [m for m in models if m.status == "converged"]
    warnings = [
        f"{m.name}: {m.status.replace('_', ' ')}; it is left out of the recommendation"
        for m in models
        if m not in sound
    ]
    if not sound:
        return Comparison(
            robot.name, elements, models, None, "No model could be fitted: see calibrate.", tuple(warnings)
        )
    best = min(sound, key=lambda m: m.criterion)
    verdict = _verdict(best, sound, ", ".join(elements))
    if best.cross_validated is not None:
        unseen = {m.name: m.cross_validated.mean for m in sound if m.cross_validated is not None}
        rival = min(unseen, key=lambda name: unseen[name])
        if unseen[rival] < CLEARLY * unseen[best.name]:
            warnings.append(
                f"{rival} predicts unseen poses better ({1e3 * unseen[rival]:.3g} mm instead of "
                f"{1e3 * unseen[best.name]:.3g} mm mean): measure more poses to decide between them"
            )
    return Comparison(robot.name, elements, models, best.name, verdict, tuple(warnings))


def _verdict(best: ComparedModel, sound: Sequence[ComparedModel], elements: str) -> str:
    others = [m for m in sound if m is not best]
    second = min(others, key=lambda m: m.criterion, default=None)
    margin = "" if second is None else f" (criterion {second.criterion - best.criterion:.3g} below {second.name}'s)"
    error = best.cross_validated or best.residual
    figure = "" if error is None else f" and leaves {1e3 * error.mean:.3g} mm mean"
    seen = " on unseen poses" if best.cross_validated else ""
    if best.name == "rigid":
        return f"Recommended: rigid; the data show no compliance of {elements}{margin}{figure}{seen}."
    return f"Recommended: {best.name} on {elements}; it explains more than it costs{margin}{figure}{seen}."


CLEARLY = 0.9
"""An error on unseen poses smaller than this share of another's is clearly better."""
