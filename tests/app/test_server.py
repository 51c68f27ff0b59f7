"""The page on a socket: who is answered, how much is read, where it listens."""

import contextlib
import dataclasses
import http.client
import socket
import threading
import time

import pytest
from typer.testing import CliRunner

from flatpunch.app.limits import LIMITS
from flatpunch.app.server import AppServer
from flatpunch.cli.app import app


@pytest.fixture(scope="module")
def server():
    """A server whose page is not asked to calculate."""
    from flatpunch.app.page import Page

    with AppServer(Page(), port=0) as found:
        thread = threading.Thread(target=lambda: found.serve_forever(poll_interval=0.05))
        thread.start()
        yield found
        found.shutdown()
        thread.join()


def asked(server, method, path, headers=None, body=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=10)
    connection.putrequest(method, path, skip_host=True)
    for name, value in {"Host": f"127.0.0.1:{server.server_address[1]}", **(headers or {})}.items():
        connection.putheader(name, value)
    connection.endheaders(body)
    try:
        response = connection.getresponse()
        return response.status, response.read(), response.headers
    finally:
        connection.close()


def test_the_page_loads_nothing_from_outside(server):
    status, text, headers = asked(server, "GET", "/")
    assert status == 200
    assert b"//" not in text.replace(b"http://www.w3.org", b"")
    assert headers["Content-Security-Policy"].startswith("default-src 'self'")
    for name in ("page.js", "form.js", "charts.js", "page.css"):
        status, text, _ = asked(server, "GET", f"/static/{name}")
        assert status == 200
        assert b"https:" not in text


def test_it_listens_at_loopback(server):
    assert server.is_local
    assert server.server_address[0] == "127.0.0.1"


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "10.0.0.7"])
def test_requests_that_name_another_machine_are_refused(server, host):
    assert asked(server, "GET", "/", {"Host": host})[0] == 403


@pytest.mark.parametrize(
    "host",
    [
        "[",
        "[::1",
        "localhost:port",
        "evil.com@127.0.0.1",
        "@localhost",
        "localhost/x",
        "localhost?x",
        "a]b",
        "localhost:99999",
    ],
)
def test_malformed_hosts_are_bad_requests(server, host):
    assert asked(server, "GET", "/", {"Host": host})[0] == 400


def test_malformed_addresses_are_bad_requests(server):
    assert asked(server, "GET", "http://[/")[0] == 400
    assert asked(server, "POST", "/api/case", {"Origin": "http://["})[0] == 400


def test_requests_from_another_page_are_refused(server):
    headers = {"Origin": "http://evil.example", "Content-Length": "0"}
    assert asked(server, "POST", "/api/case", headers)[0] == 403


@pytest.mark.parametrize(
    ("method", "path"),
    [("GET", "/file/press.csv"), ("POST", "/file/press.csv"), ("GET", "/api/start"), ("GET", "/api/job?key=a")]
    + [("POST", f"/api/{name}") for name in ("solve?tab=press", "detail", "curve", "case", "stop?key=a")],
)
@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://localhost:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Sec-Fetch-Site": "none", "Origin": "https://evil.example"},
    ],
    ids=str,
)
def test_other_sites_start_and_fetch_nothing(server, method, path, headers):
    """Images, forms and scripts of other sites; a link to the page itself may be on any."""
    assert asked(server, method, path, {**headers, "Content-Length": "0"})[0] == 403
    assert asked(server, "GET", "/", headers)[0] == 200
    assert asked(server, "GET", "/static/page.js", headers)[0] == 200


def test_the_page_itself_is_served(server):
    own = {"Origin": f"http://127.0.0.1:{server.server_address[1]}", "Content-Length": "0"}
    assert asked(server, "POST", "/api/case", {**own, "Sec-Fetch-Site": "same-origin"})[0] == 200
    assert asked(server, "GET", "/api/start", {"Sec-Fetch-Site": "same-origin"})[0] == 200
    assert asked(server, "GET", "/api/job?key=a", {"Sec-Fetch-Site": "none"})[0] == 404


def test_a_request_that_never_ends_is_ended(server, monkeypatch):
    """However regularly it sends: in the body, and in the headers."""
    from flatpunch.app import server as module

    monkeypatch.setattr(module, "LIMITS", dataclasses.replace(LIMITS, longest=0.5))
    for beginning in (
        b"POST /api/case HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n",
        b"GET / HTTP/1.1\r\nX: ",
    ):
        with socket.create_connection(("127.0.0.1", server.server_address[1])) as link:
            link.settimeout(10)
            link.sendall(beginning)
            end = time.monotonic() + 5
            with contextlib.suppress(OSError):
                while time.monotonic() < end:
                    link.sendall(b"a")
                    time.sleep(0.05)
            assert time.monotonic() < end


@pytest.mark.parametrize(
    ("path", "size"),
    [
        ("/api/case", 6_000_000),
        ("/api/curve", LIMITS.upload + 1),
        ("/api/solve?tab=press", 2_000_000),
        ("/api/case", "many"),
    ],
)
def test_bodies_that_are_too_large_are_not_read(server, path, size):
    status, text, _ = asked(server, "POST", path, {"Content-Length": str(size)})
    assert status == 413
    assert b"larger than" in text


def test_a_port_in_use_is_a_message(server):
    found = CliRunner().invoke(app, ["app", "--no-browser", "--port", str(server.server_address[1])])
    assert found.exit_code == 2
    assert "--port 0 takes a free one" in found.output


@pytest.mark.parametrize(
    "options", [["--port", "70000"], ["--port", "-1"], ["--host", "no.such.host.invalid"], ["--host", "\0"]]
)
def test_bad_addresses_are_messages(options):
    found = CliRunner().invoke(app, ["app", "--no-browser", *options])
    assert found.exit_code == 2
    assert "Traceback" not in found.output
    assert options[0] in found.output


def test_help_has_two_examples():
    text = CliRunner().invoke(app, ["app", "--help"], env={"COLUMNS": "120"}).output
    assert "flatpunch app --port 0 --no-browser" in text


def test_other_machines_are_warned_about(monkeypatch):
    from flatpunch.app import server as module

    class Stub:
        address, is_local = "http://localhost:1/", False

    monkeypatch.setattr(module, "serve", lambda host, port, ready: ready(Stub()))
    found = CliRunner().invoke(app, ["app", "--no-browser", "--host", "0.0.0.0"])
    assert "Warning: --host 0.0.0.0 lets other machines use this page" in found.output


def test_a_connection_that_breaks_off_does_no_harm(server):
    with socket.create_connection(("127.0.0.1", server.server_address[1])) as link:
        link.sendall(b"POST /api/case HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\nabc")
    assert asked(server, "GET", "/")[0] == 200
