"""The page on a socket: a small server of HTTP for one machine, from the standard library.

It is bound to the loopback interface unless another address is given, answers only requests that name this machine (so that no
web site can reach it through a name of its own), and reads no more than it says.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import quote, urlsplit

from flatpunch._support.checks import shown, whole
from flatpunch.app.limits import LIMITS
from flatpunch.app.page import Answer, Page, Request

PORT = 8517
"""Port by default, so that links work again tomorrow."""

_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class AppServer(ThreadingHTTPServer):
    """The server of the page.

    Parameters
    ----------
    page : Page
        What is served.
    host : str
        Address to listen at.
    port : int
        0 takes a free one.

    Raises
    ------
    ValueError
        If the address cannot be had.
    """

    daemon_threads = True
    # a port that another program listens at must not be shared with it
    allow_reuse_port = False

    def __init__(self, page: Page, host: str = "127.0.0.1", port: int = PORT) -> None:
        self.page, self.host = page, host
        whole("--port", port, 0, "It is a number from 0 to 65535; 0 takes a free one.", most=65535)
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
            self.address_family = found[0][0]
            super().__init__((host, port), _Handler)
        except OSError as error:
            raise ValueError(
                f"--host {shown(host)} --port {port}: the page cannot be served there ({error.strerror or error}). "
                "Choose another port; --port 0 takes a free one."
            ) from None

    @property
    def address(self) -> str:
        """Where a browser finds the page."""
        name = {"0.0.0.0": "localhost", "::": "localhost"}.get(self.host, self.host)
        return f"http://{f'[{name}]' if ':' in name else name}:{self.server_address[1]}/"

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach it."""
        return ipaddress.ip_address(str(self.server_address[0])).is_loopback

    def takes(self, host: str) -> bool:
        """Whether a request that names this host is meant for here."""
        name = urlsplit(f"//{host}").hostname or ""
        if name in ("localhost", self.host):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return not self.is_local and name.split(".")[0] == socket.gethostname().split(".")[0]
        return address.is_loopback or not self.is_local

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Keep quiet about connections that break off."""


class _Handler(BaseHTTPRequestHandler):
    """One connection."""

    protocol_version = "HTTP/1.1"
    timeout = LIMITS.silent
    server: AppServer

    def do_GET(self) -> None:
        self._answered(lambda: b"")

    def do_POST(self) -> None:
        self._answered(self._body)

    def _answered(self, body: Callable[[], bytes]) -> None:
        target = urlsplit(self.path)
        try:
            refused = self._refusal()
            read = b"" if refused else body()
        except _TooLarge as error:
            refused = str(error)
        if refused:
            # what was sent is not read, so the connection is of no more use
            self.close_connection = True
            self._send(Answer(413 if "larger" in refused else 403, refused.encode(), "text/plain; charset=utf-8"))
            return
        self._send(self.server.page.answer(Request(self.command, target.path, target.query, read)))

    def _refusal(self) -> str:
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        if not self.server.takes(host):
            return "This request names another machine."
        if self.command == "POST" and origin is not None and urlsplit(origin).netloc != host:
            return "This request comes from another page."
        return ""

    def _body(self) -> bytes:
        given = self.headers.get("Content-Length", "")
        larger = {"/api/curve": LIMITS.upload, "/api/case": 5 * LIMITS.form}
        most = larger.get(urlsplit(self.path).path, LIMITS.form)
        if not given.isdecimal() or int(given) > most:
            raise _TooLarge(f"The file is larger than {most / 1e6:g} MB, the most that is read.")
        return self.rfile.read(int(given))

    def _send(self, answer: Answer) -> None:
        self.send_response(answer.status)
        self.send_header("Content-Type", answer.type)
        self.send_header("Content-Length", str(len(answer.content)))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        if answer.name is not None:
            self.send_header("Content-Disposition", f"attachment; filename*=UTF-8''{quote(answer.name)}")
        self.end_headers()
        self.wfile.write(answer.content)

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log."""

    def version_string(self) -> str:
        """Return the name of the server."""
        return "flatpunch"


class _TooLarge(ValueError):
    """A body that is not read."""


def serve(
    host: str = "127.0.0.1", port: int = PORT, *, ready: Callable[[AppServer], None] = lambda server: None
) -> None:
    """Serve the page until it is interrupted.

    Parameters
    ----------
    host : str
        Address to listen at; other machines reach the page unless it is one of the loopback interface.
    port : int
        0 takes a free one.
    ready : callable, optional
        Called once with the server.

    Raises
    ------
    ValueError
        If the address cannot be had.
    """
    page = Page()
    with AppServer(page, host, port) as server:
        try:
            # the page is shown when the first answer takes milliseconds
            page.workers.submit("press:warm_up").wait(LIMITS.start)
            ready(server)
            server.serve_forever(poll_interval=0.2)
        finally:
            page.workers.close()
