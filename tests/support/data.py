"""The measured robot that is not part of the project."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

UR10 = Path(os.environ.get("ELASTOCAL_UR10", Path(__file__).parents[3] / "shared" / "data" / "ur10"))

needs_ur10 = pytest.mark.skipif(
    not (UR10 / "robot.toml").is_file(),
    reason="the UR10 data are not part of the project: put them in ../shared/data/ur10, or set ELASTOCAL_UR10",
)
