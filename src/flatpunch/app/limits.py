"""Sizes and times of the page. Larger ones cost memory or time, and change no number of a result."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Drawn:
    """How much of a result is sent to the browser; files have all of it.

    Parameters
    ----------
    steps : int
        Steps of a curve.
    around : int
        Polar angles of an outline, points of the outline of a tip and along a section through the layers.
    map : int
        Points along either side of a map of pressure, and down a section.
    points : int
        Points of a measured curve.
    rows, listed : int
        Rows of a file in its preview; curves and fits in a list.
    """

    steps: int = 400
    around: int = 121
    map: int = 81
    points: int = 1500
    rows: int = 5
    listed: int = 200


@dataclass(frozen=True)
class Limits:
    """What the page takes and keeps.

    Parameters
    ----------
    upload, form : int
        Largest measured file, and largest body of other requests [bytes].
    kept : int
        Results, and measured files as well, that are kept in memory, the oldest first to go [bytes].
    jobs : int
        Jobs whose outcome is kept until it is fetched.
    quick : int
        Steps above which a case is not solved while the user types.
    silent : float
        Time after which a connection that sends nothing is closed, and a job stopped that nobody has asked about, because its
        window was closed; and longest wait for the first worker process before the page is shown [s].
    longest : float
        Longest time in which a request arrives as a whole, that it waits for its outcome, and of jobs that are not polled [s].
    soon : float
        Time that a request waits for its job before it returns the job's key [s].
    """

    upload: int = 50_000_000
    form: int = 1_000_000
    kept: int = 250_000_000
    jobs: int = 200
    quick: int = 5000
    silent: float = 60.0
    longest: float = 600.0
    soon: float = 0.25


DRAWN, LIMITS = Drawn(), Limits()
