"""How rows are fitted with what was asked for: a value that workers can be sent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

from elastocal.chain import Array
from elastocal.identification.attempt import Attempt
from elastocal.identification.bounds import fit_non_negative
from elastocal.identification.gauge import Gauge
from elastocal.identification.transition import Transition, find_torques, fit_anew, problem_of
from elastocal.measurements import Measurements
from elastocal.robot import Robot


@dataclass(frozen=True)
class Fitting:
    """What every fit of a calibration has in common.

    Attributes:
        gauge: which parameters are identified.
        laws: step or hinge, by element whose transition torque is searched.
        given: transition torques [N m or N] by element, instead.
        non_negative: whether compliances are kept from becoming negative.
        seed: of a search.
    """

    gauge: Gauge
    laws: Mapping[str, str]
    given: Mapping[str, float]
    non_negative: bool
    seed: int

    def attempt(
        self,
        begin: Robot,
        rows: Measurements,
        weights: Array | None = None,
        how: Transition = "exact",
        on_step: Callable[[int, float], None] | None = None,
        on_generation: Callable[[int, int], None] | None = None,
        executor: Executor | None = None,
    ) -> Attempt:
        """Fit rows.

        Args:
            begin: where to begin: the nominal robot with its frames aligned.
            rows: to fit.
            weights: (n,) how much each row counts; None: all one.
            how: the transition torques are found.
            on_step: called with the number of steps and the sum of squares after each one.
            on_generation: called with the number of a genetic algorithm's generations done, and of all.
            executor: where the fits of a generation run.

        Raises:
            EquilibriumError: the robot does not settle.
        """
        problem = problem_of(begin, self.gauge.kept, rows, self.laws, weights)
        problem, search = find_torques(problem, how, self.given, self.seed, on_generation, executor)
        fit_all = partial(fit_anew, on_step=on_step, given=bool(self.given))
        trial, held = fit_non_negative(problem, fit_all) if self.non_negative else (fit_all(problem), ())
        return Attempt(problem, search, trial, held)
