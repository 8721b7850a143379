"""One function on many items, on any executor: this process, local processes, or a Dask cluster."""

from elastocal.parallel.cluster import Cluster
from elastocal.parallel.maps import completed, in_order, width
from elastocal.parallel.processes import LocalProcesses

__all__ = ["Cluster", "LocalProcesses", "completed", "in_order", "width"]
