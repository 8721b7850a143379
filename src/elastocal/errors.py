"""Every error that elastocal raises on purpose."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class ElastocalError(Exception):
    """Root of all errors that a user can cause and mend."""


class InputError(ElastocalError):
    """A bad input: every fault found in it, each with its place, what was expected and what was found.

    Attributes:
        faults: one sentence each.
    """

    def __init__(self, *faults: str) -> None:
        self.faults = faults
        super().__init__("\n".join(faults))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, ...]]:
        return InputError, self.faults


class EquilibriumError(ElastocalError):
    """The deflections of a pose do not settle: the named element is too soft for what hangs on it.

    Attributes:
        element: the element's name.
        pose: number of the pose among those asked for, from 0.
        place: where it comes from, "fit.csv row 12"; "" if that is not known.
    """

    def __init__(self, element: str, pose: int, place: str = "") -> None:
        self.element = element
        self.pose = pose
        self.place = place
        super().__init__(
            f"{element} does not settle under its load at {place or f'pose {pose}'}: it is too soft for what hangs "
            "on it; check its compliance [rad/(N·m)], the masses [kg] and gravity [m/s²]"
        )

    def __reduce__(self) -> tuple[type[EquilibriumError], tuple[str, int, str]]:
        return EquilibriumError, (self.element, self.pose, self.place)


class WorkerLostError(ElastocalError):
    """The process or machine that was at work on an item is gone, and so was each one that took over."""


class ClusterLostError(ElastocalError):
    """The cluster's scheduler is gone, and with it all that was under way."""


def unknown_name(kind: str, name: str, valid: Iterable[str]) -> str:
    """A sentence on a name that does not exist: the nearest valid one, and all that are valid."""
    choices = [str(choice) for choice in valid]
    near = get_close_matches(name, choices, n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    listed = ", ".join(choices[:40]) + (", …" if len(choices) > 40 else "") if choices else "none"
    return f"no {kind} {name!r}{hint} (valid: {listed})"
