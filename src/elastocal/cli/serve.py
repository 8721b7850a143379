"""The command `elastocal serve`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number


def serve(
    folder: Path = Path("elastocal-runs"),
    /,
    *,
    port: Annotated[int, Parameter(validator=Number(gte=1, lte=65535))] = 8722,
    browser: Annotated[bool, Parameter(name="--browser", negative="--no-browser")] = True,
) -> int:
    """A local page to calibrate robots in: files in, settings, progress, results.

    The page is seen on this computer only (127.0.0.1). Its runs are kept in a folder and are there again next time; a
    run that is at work when the page is closed down is interrupted, and can be run again.

    Args:
        folder: of the runs; made if it is not there.
        port: that the page listens at.
        browser: whether to open the page in the browser.
    """
    from elastocal.cli.main import DONE
    from elastocal.web.server import listening, serve_folder

    with listening(port) as found:
        address = f"http://127.0.0.1:{port}"
        print(f"elastocal: {address} (runs in {folder}); Ctrl-C ends it", file=sys.stderr)
        serve_folder(folder, found, address if browser else None)
    return DONE
