"""What the calibrations of a fleet say together: accuracy, who differs from siblings, drift between dates."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import pairwise

from elastocal.drift import Difference, difference
from elastocal.errors import ElastocalError
from elastocal.fleet.siblings import Siblings, siblings_of
from elastocal.fleet.task import FAILED, FleetOutcome
from elastocal.identification import SavedResult, Statistics
from elastocal.identification.threads import one_thread
from elastocal.parallel import in_order

JUDGED_BY = (("held_out_nominal", "held_out"), ("nominal", "cross_validated"), ("nominal", "calibrated"))
"""Errors before and after: of rows held out if there are any, else the ones to expect, else those of the fit."""


@dataclass(frozen=True)
class Drift:
    """Two calibrations of one robot, one after the other.

    Attributes:
        before, after: their dates.
        found: what changed; None if they cannot be compared, for a `reason`.
    """

    serial: str
    before: str
    after: str
    found: Difference | None
    reason: str = ""


@dataclass(frozen=True)
class FleetSummary:
    """A fleet's calibrations.

    Attributes:
        outcomes: of the rows, in the manifest's order.
        siblings: robots side by side, those of each kind.
        drifts: of each serial from date to date.
        verdict: one sentence.
    """

    outcomes: tuple[FleetOutcome, ...]
    siblings: tuple[Siblings, ...]
    drifts: tuple[Drift, ...]
    verdict: str

    @property
    def failed(self) -> tuple[FleetOutcome, ...]:
        """Rows without a result that converged."""
        return tuple(outcome for outcome in self.outcomes if outcome.status != "converged")


def accuracy(result: SavedResult) -> tuple[str, Statistics | None, Statistics | None]:
    """Which rows a calibration is judged by, and their errors before and after it."""
    for before, after in JUDGED_BY:
        if after in result.residuals:
            return after, result.residuals.get(before), result.residuals[after]
    return "", None, None


def summarised(outcomes: Sequence[FleetOutcome], robots: Sequence[str], executor: Executor | None) -> FleetSummary:
    """What the outcomes say together.

    Args:
        outcomes: of all rows.
        robots: something that tells the nominal robot of each row.
        executor: where calibrations are compared.
    """
    of_serial: dict[str, list[tuple[FleetOutcome, SavedResult]]] = defaultdict(list)
    kinds: dict[tuple[object, ...], list[tuple[str, SavedResult]]] = defaultdict(list)
    nominal = {outcome.row.number: robot for outcome, robot in zip(outcomes, robots, strict=True)}
    for outcome in outcomes:
        if outcome.result is not None and outcome.status == "converged":
            of_serial[outcome.row.serial].append((outcome, outcome.result))
    for serial, found in of_serial.items():
        found.sort(key=lambda one: one[0].row.date)
        last, result = found[-1]
        laws = tuple(sorted((element, one.law) for element, one in result.robot.elastic.items()))
        kinds[nominal[last.row.number], frozenset(result.names), laws].append((serial, result))
    groups = tuple(siblings_of(*map(list, zip(*found, strict=True))) for found in kinds.values())
    pairs = [(serial, one, other) for serial, found in of_serial.items() for one, other in pairwise(found)]
    differences = in_order(_difference, [(one[1], other[1]) for _, one, other in pairs], executor)
    drifts = tuple(
        Drift(serial, one[0].row.date, other[0].row.date, *found)
        for (serial, one, other), found in zip(pairs, differences, strict=True)
    )
    return FleetSummary(tuple(outcomes), groups, drifts, _verdict(outcomes, groups, drifts))


@one_thread
def _difference(pair: tuple[SavedResult, SavedResult]) -> tuple[Difference | None, str]:
    """What changed, as `diff` tells it; or why the two cannot be compared."""
    try:
        return difference(*pair), ""
    except ElastocalError as error:
        return None, str(error)


def _verdict(outcomes: Sequence[FleetOutcome], groups: Sequence[Siblings], drifts: Sequence[Drift]) -> str:
    failed = sum(outcome.status == FAILED for outcome in outcomes)
    weak = sum(outcome.status not in (FAILED, "converged") for outcome in outcomes)
    kept = sum(outcome.kept for outcome in outcomes)
    odd = len({deviation.serial for group in groups for deviation in group.deviations})
    moved = len({drift.serial for drift in drifts if drift.found is not None and drift.found.drift})
    parts = [f"{len(outcomes) - failed - weak} of {len(outcomes)} calibrations are done"]
    parts += [f"{kept} of them from an earlier run"] if kept else []
    parts += [f"{failed} failed"] if failed else []
    parts += [f"{weak} came to no sound result"] if weak else []
    parts += [f"{odd} {'robot differs' if odd == 1 else 'robots differ'} from siblings"] if odd else []
    parts += [f"{moved} drifted"] if moved else []
    return ", ".join(parts) + "."
