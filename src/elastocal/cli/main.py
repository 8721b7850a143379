"""The `elastocal` command: its subcommands, and what becomes of errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from elastocal.errors import ElastocalError

DONE, FAILED, BAD_INPUT, STOPPED = 0, 1, 2, 130
"""Exit status: done; ran, but the verdict is failure; bad input or usage; ctrl-C."""

COMMANDS = {
    "calibrate": (
        "Identify a robot's geometry and compliance from measurements.",
        "elastocal calibrate robot.toml tracker.csv --elastic 2,3 --holdout 0.3 -o result",
    ),
    "compare": (
        "Rigid, linear, step, hinge and cubic joints side by side on the same data, and which to believe.",
        "elastocal compare robot.toml tracker.csv --elastic 2,3",
    ),
    "validate": (
        "Errors of a robot, nominal or calibrated, on measurements it was not fitted to.",
        "elastocal validate result/robot.toml tracker2.csv --refit base",
    ),
    "diff": (
        "What changed between two calibrations of one robot, in units of its uncertainty: drift, or noise?",
        "elastocal diff result-march result-june",
    ),
    "plan": (
        "Which poses to measure: a table for calibrate, to be filled in, and how accurate the robot will be.",
        "elastocal plan robot.toml --poses 45 --elastic 2,3 -o poses.csv",
    ),
    "fleet": (
        "Many robots: a result for each, who differs from its siblings, who drifted; on this machine or a cluster.",
        "elastocal fleet robots.csv -o calibrations",
    ),
    "study": (
        "Many simulated calibrations over a grid: errors against poses, coverage, whether the right law is found.",
        "elastocal study number_of_poses.toml -o results",
    ),
    "compensate": (
        "Joint commands that put the real, loaded robot on its targets: a table.",
        "elastocal compensate result/robot.toml targets.csv --nominal robot.toml -o corrected.csv",
    ),
    "report": (
        "The report on a calibration as a web page that opens offline; or several calibrations side by side.",
        "elastocal report result-linear result-step -o comparison.html",
    ),
    "simulate": (
        "Measurements of a robot that does not exist: a table for calibrate, with a known truth.",
        "elastocal simulate robot.toml --poses 60 --geometry-error 0.5mm,0.5mrad --noise 0.03mm -o fit.csv",
    ),
    "export": (
        "The identified robot for other software: URDF, DH tables, UR's kinematics file, corrections.",
        "elastocal export result/robot.toml --to urdf -o calibrated.urdf",
    ),
    "reproduce": (
        "The two papers on joint stiffness, their tables beside ours, each run anew.",
        "elastocal reproduce a-1 b-2 nonlinear",
    ),
    "serve": (
        "A local page to calibrate robots in: drop files, watch runs, look at results, compare them.",
        "elastocal serve my-runs",
    ),
    "demo": (
        "The whole way on a built-in example: robot file, measurements, calibration, validation.",
        "elastocal demo -o elastocal-demo",
    ),
    "new": (
        "A commented robot file and an empty measurement table to fill in.",
        "elastocal new my-robot --joints 6 --convention standard-dh",
    ),
}
"""Summary and example of each command."""


def build_app() -> App:
    """The application, its commands not yet imported."""
    app = App(
        name="elastocal",
        help="Robot calibration that models what bends: geometry and joint stiffness from measured poses.",
        help_epilogue="Try `elastocal demo`. Every command explains itself: `elastocal calibrate --help`.",
        result_action="return_value",
        exit_on_error=False,
        suppress_keyboard_interrupt=False,  # commands say what is kept
        help_format="markdown",
    )
    for name, (summary, example) in COMMANDS.items():
        app.command(f"elastocal.cli.{name}:{name}", name=name, help=summary, help_epilogue=f"Example: `{example}`")
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line and return its exit status."""
    try:
        status = build_app()(arguments)
        sys.stdout.flush()
    except CycloptsError:
        return BAD_INPUT
    except ElastocalError as error:
        for line in str(error).splitlines():
            print(f"elastocal: {line}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as error:
        print(f"elastocal: {error or 'stopped'}", file=sys.stderr)
        return STOPPED
    except OSError as error:
        if not isinstance(error, BrokenPipeError):
            print(f"elastocal: {error.filename or 'system'}: {(error.strerror or str(error)).lower()}", file=sys.stderr)
            return BAD_INPUT
        # who reads has enough, as `| head` does; nothing must be left to be written at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    return status if isinstance(status, int) else DONE


def run() -> None:
    """Entry point of the installed command."""
    sys.exit(main())
