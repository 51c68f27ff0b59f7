"""The page on a socket: a small server of HTTP for one machine, from the standard library.

It is bound to the loopback interface unless another address is given, answers only requests that name this machine (so that no
web site can reach it through a name of its own), from other sites nothing but its files and its first page (which a link may
open), and reads no more and no longer than it says.
"""

from __future__ import annotations

import ipaddress
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import SplitResult, quote, urlsplit

from flatpunch._support.checks import shown, whole
from flatpunch.app.limits import LIMITS
from flatpunch.app.page import Answer, Page, Request
from flatpunch.files.cases import LARGEST

PORT = 8517
"""Port by default, so that links work again tomorrow."""

_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class AppServer(ThreadingHTTPServer):
    """The server of a page at an address; port 0 takes a free one. A ValueError says that the address cannot be had."""

    daemon_threads = True
    # a port that another program listens at must not be shared with it
    allow_reuse_port = False

    def __init__(self, page: Page, host: str = "127.0.0.1", port: int = PORT) -> None:
        self.page, self.host = page, host
        whole("--port", port, 0, "It is a number from 0 to 65535; 0 takes a free one.", most=2**16 - 1)
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

    def takes(self, name: str) -> bool:
        """Whether a request to a host of this name is meant for here."""
        if name in ("localhost", self.host):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return not self.is_local and name.split(".")[0] == socket.gethostname().split(".")[0]
        return address.is_loopback or not self.is_local

    def handle_error(self, request: object, client_address: object) -> None:
        """Keep quiet about connections that break off."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    timeout = LIMITS.silent
    server: AppServer

    def handle_one_request(self) -> None:
        """Handle a request, which must have arrived within a time however slowly it is sent."""
        self._late = threading.Timer(LIMITS.longest, self._no_more)
        self._late.daemon = True
        self._late.start()
        try:
            super().handle_one_request()
        finally:
            self._late.cancel()

    def _no_more(self) -> None:
        self.close_connection = True
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RD)

    def do_GET(self) -> None:
        self._answered(lambda: b"")

    def do_POST(self) -> None:
        self._answered(self._body)

    def _answered(self, body: Callable[[], bytes]) -> None:
        try:
            target = _split(self.path)
            self._check_origin()
            read = body()
        except _Refused as refused:
            # what was sent is not read, so the connection is of no more use
            self.close_connection = True
            self._send(Answer(refused.status, str(refused).encode(), "text/plain; charset=utf-8"))
            return
        self._late.cancel()
        self._send(self.server.page.answer(Request(self.command, target.path, target.query, read)))

    def _check_origin(self) -> None:
        """Refuse requests to another machine and those of another page."""
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        place = _split(f"//{host}")
        if place.netloc != host or place.username is not None:
            raise _Refused(HTTPStatus.BAD_REQUEST, "The request names no host.")
        if not self.server.takes(place.hostname or ""):
            raise _Refused(HTTPStatus.FORBIDDEN, "This request names another machine.")
        path = _split(self.path).path
        if self.command == "GET" and (path == "/" or path.startswith("/static/")):
            return
        # browsers name the page, or at least how near it is; what is no browser names neither
        if (origin is not None and _split(origin).netloc != host) or self.headers.get("Sec-Fetch-Site", "none") not in (
            "none",
            "same-origin",
        ):
            raise _Refused(HTTPStatus.FORBIDDEN, "This request comes from another page.")

    def _body(self) -> bytes:
        given = self.headers.get("Content-Length", "")
        larger = {"/api/curve": LIMITS.upload, "/api/case": LARGEST}
        most = larger.get(_split(self.path).path, LIMITS.form)
        if not given.isdecimal() or int(given) > most:
            raise _Refused(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                f"The file is larger than {most / 1e6:g} MB, the most that is read.",
            )
        found = self.rfile.read(int(given))
        if len(found) < int(given):
            raise _Refused(HTTPStatus.REQUEST_TIMEOUT, f"The request did not arrive within {LIMITS.longest:g} s.")
        return found

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

    def log_message(self, format: str, *args: object) -> None:
        """Write no log."""

    def version_string(self) -> str:
        return "flatpunch"


class _Refused(ValueError):
    """A request that is not served, with the HTTP status that says so."""

    def __init__(self, status: HTTPStatus, reason: str) -> None:
        super().__init__(reason)
        self.status = status


def _split(address: str) -> SplitResult:
    """Parts of an address; refused where it is none."""
    try:
        parts = urlsplit(address)
        # read here, since a port that is no number is found only when it is asked for
        _ = parts.port
    except ValueError:
        raise _Refused(HTTPStatus.BAD_REQUEST, "The address of the request cannot be read.") from None
    return parts


def serve(
    host: str = "127.0.0.1", port: int = PORT, *, ready: Callable[[AppServer], None] = lambda server: None
) -> None:
    """Serve the page until it is interrupted; `ready` is called once with the server.

    Other machines reach the page unless the host is one of the loopback interface. Port 0 takes a free one.
    """
    page = Page()
    with AppServer(page, host, port) as server:
        try:
            # the page is shown when the first answer takes milliseconds
            page.workers.submit("press:warm_up").wait(LIMITS.silent)
            ready(server)
            server.serve_forever()
        finally:
            page.workers.close()
