"""The command `flatpunch app`: the page in the browser for the daily jobs."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch.cli.terminal import command, say

if TYPE_CHECKING:
    from flatpunch.app.server import AppServer


@command("app", interrupted="")
def page(
    port: Annotated[int, typer.Option(help="Port of the page; 0 takes a free one.")] = 8517,
    host: Annotated[
        str, typer.Option(help="Address to listen at. Other machines reach the page unless it is 127.0.0.1.")
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option(help="Whether to open the page in the browser.")] = True,
) -> None:
    """Open a page in the browser: press, fit, correct a reported modulus, coatings, compare formulas.

    The page runs on this machine, and no data leaves it; Ctrl-C ends it. Nothing is written but what you save.
    """
    from flatpunch.app.server import serve

    def ready(server: AppServer) -> None:
        say(f"The page is at {server.address}   Ctrl-C ends it.")
        if not server.is_local:
            typer.echo(
                f"Warning: --host {host} lets other machines use this page and its calculations. It asks for no "
                "password; leave --host out to serve this machine only.",
                err=True,
            )
        if browser and _has_display():
            import webbrowser

            webbrowser.open(server.address)

    serve(host, port, ready=ready)


def _has_display() -> bool:
    """Whether a browser with windows can be opened; one in the terminal would take the terminal."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
