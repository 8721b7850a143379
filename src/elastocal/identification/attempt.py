"""One fit from end to end, with what led to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from elastocal.identification.partitioned import Partitioned
from elastocal.identification.priors import PriorFit
from elastocal.identification.solver import Solution
from elastocal.identification.step_torques import StepTorque
from elastocal.identification.transition import Problem, Search, Trial
from elastocal.prediction import Model
from elastocal.robot import Robot


@dataclass(frozen=True)
class Whole:
    """What a fit of all rows of partitions has beside that of its sample.

    Attributes:
        model: of all rows.
        nominal: the robot before, its open frames fitted to all rows.
        sampled: the fit of the sample, with the transition torques that all rows tell.
        steps: transition torques of steps as all rows tell them, by element.
    """

    model: Partitioned
    nominal: Robot
    sampled: Trial
    steps: Mapping[str, StepTorque]


@dataclass(frozen=True)
class Attempt:
    """A fit of some rows with the laws asked for.

    Attributes:
        problem: what was fitted.
        search: how transition torques were found; None where there were none to find.
        trial: the fit.
        held: compliances held at zero.
        prior: the fit with priors that followed; None without them.
        whole: the fit of all rows, of which `model` has a sample; None where all rows are in memory.
    """

    problem: Problem
    search: Search | None
    trial: Trial
    held: tuple[str, ...]
    prior: PriorFit | None = None
    whole: Whole | None = None

    @property
    def model(self) -> Model:
        """What was fitted in the end; of the rows in memory."""
        model = self.trial.model
        return replace(model, robot=self.prior.robot, names=self.prior.names) if self.prior else model

    @property
    def summed(self) -> Model | Partitioned:
        """The same of all rows."""
        if self.whole is None:
            return self.model
        return replace(self.whole.model, robot=self.model.robot, names=self.model.names)

    @property
    def nominal(self) -> Robot:
        """The robot before, its open frames fitted to all rows."""
        return self.whole.nominal if self.whole else self.trial.model.robot

    @property
    def searched(self) -> Trial:
        """The fit that transition torques were searched with, of the rows in memory."""
        return self.whole.sampled if self.whole else self.trial

    @property
    def solution(self) -> Solution:
        """Where the fit ended."""
        return self.prior.solution if self.prior else self.trial.solution
