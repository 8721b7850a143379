"""What the data say of the transition torques found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import HINGE
from elastocal.identification.transition.grid import SAME
from elastocal.identification.transition.search import Search
from elastocal.identification.transition.trial import Trial


@dataclass(frozen=True)
class TransitionData:
    """The data on both sides of a transition torque.

    Attributes:
        gap: the largest load below it and the smallest above it [N m or N].
        below, above: how many different loads there are on each side.
        searched: whether the torque was searched; else it was given.
    """

    gap: tuple[float, float]
    below: int
    above: int
    searched: bool


def transitions_of(trial: Trial, search: Search | None) -> dict[str, TransitionData]:
    """The data on both sides of a fit's transition torques, by element."""
    searched = search is not None and search.method != "given"
    found = {}
    for element, torque in trial.torques.items():
        sizes = np.sort(np.abs(trial.loads[element]))
        below, above = sizes[sizes < torque], sizes[sizes >= torque]
        gap = float(below[-1]) if len(below) else 0.0, float(above[0]) if len(above) else float("inf")
        least = SAME * float(sizes[-1])
        found[element] = TransitionData(gap, _different(below, least), _different(above, least), searched)
    return found


def _different(ordered: Array, least: float) -> int:
    return int((np.diff(ordered) > least).sum()) + 1 if len(ordered) else 0


def free_torques(trial: Trial, search: Search | None) -> tuple[str, ...]:
    """Names of the transition torques that the misfit follows smoothly: those of hinges, unless they are given."""
    if search is None or search.method == "given":
        return ()
    elastic = trial.model.robot.elastic
    return tuple(f"{element}.transition_torque" for element in trial.torques if elastic[element].law == HINGE.name)
