"""`python -m elastocal`."""

from elastocal.cli.main import run

run()
