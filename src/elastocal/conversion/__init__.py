"""Conversion: a robot in other forms, and how far two robots are apart."""

from elastocal.conversion.corrections import RowChange, nominal_geometry, row_changes, with_offsets_only
from elastocal.conversion.denavit_hartenberg import LONGEST, Table, dh_table
from elastocal.conversion.deviation import Residual, residuals_left, rigid
from elastocal.conversion.segments import Segment, aligned_joints, frame_of, homogeneous, segments

__all__ = [
    "LONGEST",
    "Residual",
    "RowChange",
    "Segment",
    "Table",
    "aligned_joints",
    "dh_table",
    "frame_of",
    "homogeneous",
    "nominal_geometry",
    "residuals_left",
    "rigid",
    "row_changes",
    "segments",
    "with_offsets_only",
]
