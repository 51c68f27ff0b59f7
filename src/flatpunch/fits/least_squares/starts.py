"""Where a search begins: trials of parameters and contact points, each with the best amplitude of the force and background."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from operator import itemgetter

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fits.parameters.unknowns import Unknowns

CONTACTS = 24
"""Contact points that are tried."""


def tried(
    objective: Unknowns,
    thetas: Iterable[Array],
    between: tuple[float, float],
    force: Callable[[Array, Array], Array],
    scaled: Sequence[int],
) -> list[Array]:
    """Trials, the best first: all of `thetas` with contact points between two, if these are free.

    At each trial the force of the contact counts by a factor, and the background is fitted: both are linear.

    Parameters
    ----------
    objective : Unknowns
        Readings and background.
    thetas : iterable of ndarray, shape (free,)
        Internal parameters.
    between : tuple of float
        First and last contact point [m].
    force : callable
        (theta, contact points of shape (m,)) -> force of the contact [N], shape (m, n).
    scaled : sequence of int
        Places of the parameters that are in proportion to the force together; empty where there are none.
    """
    place, held = objective.position, objective.held
    span, level, (origin, width) = objective.frame.span, objective.frame.level, objective.units["contact"]
    free, linear = "contact" in objective.nuisance, [name for name in objective.nuisance if name != "contact"]
    contacts = (
        np.linspace(*between, CONTACTS if between[0] < between[1] else 1) if free else np.array([held["contact"]])
    )
    columns = [objective.column(name, held, place, objective.speed) for name in linear]
    known = (level if "baseline" in linear else held["baseline"]) + objective.background(held, place, objective.speed)
    data = (objective.force - known) / span
    root, found = np.sqrt(1.0 if objective.counts is None else objective.counts), []
    for theta in thetas:
        for contact, row in zip(contacts, force(theta, contacts) / span, strict=True):
            wanted = root * (data if scaled else data - row)
            rows = root * np.reshape([*columns, *([row] if scaled else [])], (-1, data.size))
            best = np.linalg.lstsq(rows.T, wanted, rcond=None)[0]
            left = wanted - best @ rows
            x = np.concatenate([theta, np.zeros(len(objective.nuisance))])
            if scaled:
                x[list(scaled)] += np.log(max(best[-1], TINY))
            values = dict(zip(linear, best, strict=False)) | {"contact": (contact - origin) / width}
            x[theta.size :] = [values[name] for name in objective.nuisance]
            found.append((float(left @ left) if not scaled or best[-1] > 0 else np.inf, x))
    return [x for _, x in sorted(found, key=itemgetter(0))]
