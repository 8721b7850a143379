"""Many robots: one calibration for each row of a manifest, and what they say together."""

from elastocal.fleet.run import require_fleet, run_fleet
from elastocal.fleet.siblings import Deviation, Siblings
from elastocal.fleet.summary import Drift, FleetSummary, accuracy
from elastocal.fleet.tables import fleet_json, fleet_tables
from elastocal.fleet.task import FleetOutcome

__all__ = [
    "Deviation",
    "Drift",
    "FleetOutcome",
    "FleetSummary",
    "Siblings",
    "accuracy",
    "fleet_json",
    "fleet_tables",
    "require_fleet",
    "run_fleet",
]
