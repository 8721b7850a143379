"""Measurements in parts that are in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.partitions import Partitions, drawn


@dataclass(frozen=True)
class HeldPart:
    """A part that need not be read."""

    data: Measurements

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self.data)

    def read(self) -> Measurements:
        """The rows."""
        return self.data


def in_parts(data: Measurements, rows: int, sample: int) -> Partitions:
    """Measurements in parts of so many rows, with a sample of so many or a little more."""
    parts = [data.take(np.arange(first, min(first + rows, len(data)))) for first in range(0, len(data), rows)]
    share = min(1.0, sample / len(data))
    few = [part.take(drawn(part, share, number)) for number, part in enumerate(parts)]
    return Partitions(tuple(map(HeldPart, parts)), concatenate(few))


def numbered(data: Measurements, file: str = "fit.parquet") -> Measurements:
    """The measurements as if they came from a file."""
    n = len(data)
    places = {"source": Labels((file,), np.zeros(n, dtype=np.int32)), "row": np.arange(1, n + 1)}
    return Measurements(**{**vars(data), **places})
