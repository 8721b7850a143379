"""One fit from end to end, with what led to it."""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.identification.priors import PriorFit
from elastocal.identification.solver import Solution
from elastocal.identification.transition import Problem, Search, Trial
from elastocal.prediction import Model


@dataclass(frozen=True)
class Attempt:
    """A fit of some rows with the laws asked for.

    Attributes:
        problem: what was fitted.
        search: how transition torques were found; None where there were none to find.
        trial: the fit.
        held: compliances held at zero.
        prior: the fit with priors that followed; None without them.
    """

    problem: Problem
    search: Search | None
    trial: Trial
    held: tuple[str, ...]
    prior: PriorFit | None = None

    @property
    def model(self) -> Model:
        """What was fitted in the end."""
        return self.prior.model if self.prior else self.trial.model

    @property
    def solution(self) -> Solution:
        """Where the fit ended."""
        return self.prior.solution if self.prior else self.trial.solution
