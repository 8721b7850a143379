"""What a compensation comes to: row by row, and in sums."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array


@dataclass(frozen=True)
class Rows:
    """Corrected targets, one a row, in the order of the targets; SI units, base frame.

    Attributes:
        q: (n, joints) the joint positions to command [rad or m].
        reached: (n,) whether the loaded robot is then at its target, to 1e-9 m and rad.
        correction: (n,) how far the command is shifted: between the target and where the nominal robot would be [m].
        correction_angle: (n,) likewise [rad]; NaN where the orientation does not matter.
        error_before: (n,) of the loaded robot with the nominal robot's joint positions [m].
        error_after: (n,) with `q` [m].
        angle_before, angle_after: (n,) likewise [rad]; NaN where the orientation does not matter.
        nominal_q: (n, joints) the nominal robot's joint positions.
        fake_position, fake_rotation: (n, 3), (n, 3, 3) where the nominal robot would be at `q`: the targets to give to
            a controller that keeps its nominal kinematics.
        notes: (n,) a sentence on rows that need one, else "".
    """

    q: Array
    reached: NDArray[np.bool_]
    correction: Array
    correction_angle: Array
    error_before: Array
    error_after: Array
    angle_before: Array
    angle_after: Array
    nominal_q: Array
    fake_position: Array
    fake_rotation: Array
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.q)

    @classmethod
    def joined(cls, parts: Sequence[Rows]) -> Rows:
        """Blocks of rows one after the other."""
        columns = {f.name: [getattr(part, f.name) for part in parts] for f in fields(cls)}
        notes = tuple(note for part in columns.pop("notes") for note in part)
        return cls(**{name: np.concatenate(values) for name, values in columns.items()}, notes=notes)


@dataclass(frozen=True)
class Spread:
    """Mean and largest of what so many rows have."""

    n: int = 0
    total: float = 0.0
    max: float = 0.0

    @property
    def mean(self) -> float:
        """NaN of none."""
        return self.total / self.n if self.n else np.nan

    def with_rows(self, values: Array) -> Spread:
        """With further values, those that are NaN left out."""
        known = values[np.isfinite(values)]
        largest = max(self.max, float(known.max(initial=0.0)))
        return Spread(self.n + len(known), self.total + float(known.sum()), largest)


FIGURES = ("correction", "correction_angle", "error_before", "error_after", "angle_before", "angle_after")


@dataclass(frozen=True)
class Summary:
    """All rows of a compensation in sums.

    Attributes:
        robot: its name.
        targets: how many.
        reached: how many of them.
        figures: spread of each of FIGURES, over the targets that are reached.
        missed: the first targets that are not reached: number, from 1, and note.
        noted: how many rows have a note.
        warnings: sentences on all of it.
    """

    robot: str
    targets: int = 0
    reached: int = 0
    figures: dict[str, Spread] = field(default_factory=lambda: dict.fromkeys(FIGURES, Spread()))
    missed: tuple[tuple[int, str], ...] = ()
    noted: int = 0
    warnings: tuple[str, ...] = ()

    def with_rows(self, rows: Rows) -> Summary:
        """With a further block."""
        kept = rows.reached
        figures = {name: spread.with_rows(getattr(rows, name)[kept]) for name, spread in self.figures.items()}
        missed = [(self.targets + int(i) + 1, rows.notes[i]) for i in np.flatnonzero(~kept)]
        return Summary(
            self.robot,
            self.targets + len(rows),
            self.reached + int(kept.sum()),
            figures,
            (*self.missed, *missed)[:MOST_MISSED],
            self.noted + sum(map(bool, rows.notes)),
            self.warnings,
        )


MOST_MISSED = 10


@dataclass(frozen=True)
class Compensation(Rows):
    """What `compensate` gives back: the rows, and their sums in `summary`."""

    summary: Summary = field(default_factory=lambda: Summary(""))

    @classmethod
    def of(cls, parts: Iterable[Rows], summary: Summary) -> Compensation:
        """Blocks of rows put together."""
        whole = Rows.joined(list(parts))
        return cls(**{f.name: getattr(whole, f.name) for f in fields(Rows)}, summary=summary)

    def __str__(self) -> str:
        from elastocal.compensation.words import summary_text

        return summary_text(self.summary)
