"""What is let in: requests of this page's own origin and of bounded size; and the headers of every answer."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOCAL = ("127.0.0.1", "localhost")

SAFE = ("GET", "HEAD")

MOST_UPLOAD = 200 * 1024 * 1024
"""Bytes of one uploaded file, at most."""

MOST_FORM = 256 * 1024
"""Bytes of any other request, at most."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
"""Scripts come from files of this page only. Inline styles are let in because plotly makes style elements."""

REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'; sandbox allow-scripts allow-downloads allow-modals"
)
"""A report is one file with its own scripts: it gets an origin of its own, from which nothing here can be asked."""

HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
"""Of every answer that does not set them itself."""


class Guard:
    """Middleware that refuses other hosts, other origins and bodies that are too large, before anything else runs."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let one request in, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            return

        begun = False

        async def send_guarded(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                present = {name.lower() for name, _ in message["headers"]}
                added = [(k.encode(), v.encode()) for k, v in HEADERS.items() if k.encode() not in present]
                message = {**message, "headers": [*message["headers"], *added]}
            await send(message)

        connection = HTTPConnection(scope)
        limit = MOST_UPLOAD if scope["method"] == "PUT" else MOST_FORM
        refused = foreign(scope["method"], connection, scope.get("server")) or too_large(connection.headers, limit)
        if refused is not None:
            status, reason = refused
            answer = PlainTextResponse(reason, status, {"connection": "close"})
            await answer(scope, receive, send_guarded)
            return
        try:
            await self.app(scope, _bounded(receive, limit), send_guarded)
        except Exception:
            # nothing of it goes to the browser; a second start of an answer that has begun would be an error too
            logging.getLogger("uvicorn.error").exception("%s %s", scope["method"], scope["path"])
            if not begun:
                await PlainTextResponse("This did not work; the terminal says why.", 500)(scope, receive, send_guarded)


def foreign(method: str, connection: HTTPConnection, server: tuple[str, int | None] | None) -> tuple[int, str] | None:
    """Why a request is not one of this page's own: status and sentence; None if it is.

    A name that leads to this computer without being its own (DNS rebinding) is told by the Host header; a request that
    another site makes the browser send, by Origin and Sec-Fetch-Site.
    """
    headers, port = connection.headers, server[1] if server else None
    host = headers.get("host", "")
    own = [f"{name}:{port}" for name in LOCAL] + ([*LOCAL] if port == 80 else [])
    if host not in own:
        return 400, f"This page is at http://127.0.0.1:{port}, on this computer only."
    origin, site = headers.get("origin"), headers.get("sec-fetch-site")
    if origin is not None and origin != f"http://{host}":
        return 403, "A request from another origin is refused."
    if method in SAFE:
        opened = headers.get("sec-fetch-mode") == "navigate" and headers.get("sec-fetch-dest") == "document"
        same = site in (None, "same-origin", "none") or opened
    else:
        same = site == "same-origin" or (site is None and origin is not None)
    return None if same else (403, "A request from another origin is refused.")


def too_large(headers: Mapping[str, str], limit: int) -> tuple[int, str] | None:
    """Why a body is not read at all: status and sentence; None if it may be."""
    length = headers.get("content-length", "0")
    if not length.isdecimal():
        return 400, "Content-Length: expected a number."
    return (413, size_sentence(limit)) if int(length) > limit else None


def size_sentence(limit: int) -> str:
    """What is said of a body over the limit."""
    return f"Too large: a file may have {limit >> 20} MB at most."


def _bounded(receive: Receive, limit: int) -> Receive:
    """The same body, ended with status 413 where it grows over the limit, whatever length it stated."""
    seen = 0

    async def bounded() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > limit:
            raise HTTPException(413, size_sentence(limit))
        return message

    return bounded
