"""What several test files share in one process: playwright's synchronous interface can be opened once only."""

from __future__ import annotations

from support.browser import browser

__all__ = ["browser"]
