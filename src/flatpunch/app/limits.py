"""Sizes and times of the page. Larger ones cost memory or time, and change no number of a result."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Drawn:
    """How much of a result is sent to the browser; files have all of it.

    Parameters
    ----------
    steps, angles : int
        Steps of a curve, and polar angles of an outline.
    points : int
        Points of a measured curve.
    map : int
        Points along either side of a map of pressure.
    section : (int, int)
        Points of a section through the layers, across and down.
    tip : int
        Points of the outline of a tip.
    rows, listed : int
        Rows of a file in its preview; curves and fits in a list.
    """

    steps: int = 400
    angles: int = 121
    points: int = 1500
    map: int = 81
    section: tuple[int, int] = (121, 81)
    tip: int = 121
    rows: int = 5
    listed: int = 200


@dataclass(frozen=True)
class Limits:
    """What the page takes and keeps.

    Parameters
    ----------
    upload, form : int
        Largest measured file, and largest body of other requests [bytes].
    results, uploads : int
        Results and measured files that are kept in memory, the oldest first to go [bytes].
    jobs : int
        Jobs whose outcome is kept until it is fetched.
    quick : int
        Steps above which a case is not solved while the user types.
    silent : float
        Time after which a connection that sends nothing is closed [s].
    arrival : float
        Longest time in which a request arrives as a whole [s].
    longest : float
        Longest time that a request waits for its outcome, and of jobs that are not polled as results are [s].
    soon : float
        Time that a request waits for its job before it returns the job's key [s].
    forgotten : float
        Time after which a job is stopped that nobody has asked about, because its window was closed [s].
    start : float
        Longest wait for the first worker process before the page is shown [s].
    """

    upload: int = 50_000_000
    form: int = 1_000_000
    results: int = 300_000_000
    uploads: int = 250_000_000
    jobs: int = 200
    quick: int = 5000
    silent: float = 60.0
    arrival: float = 300.0
    longest: float = 600.0
    soon: float = 0.25
    forgotten: float = 60.0
    start: float = 20.0


DRAWN, LIMITS = Drawn(), Limits()
