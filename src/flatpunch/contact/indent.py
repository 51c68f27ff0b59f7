"""`indent` and `pressure`: one front for every medium, indenter and method."""

from __future__ import annotations

import inspect
import json
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.ceilings import ANGLES, OUTLINES
from flatpunch._support.checks import Array, numbers, positive, shown, values, whole
from flatpunch._support.overflow import refused_overflow
from flatpunch._support.prefixes import text
from flatpunch._support.record import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliance import Kernel, compliance
from flatpunch.contact.curve import Control, Curve, control_from
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.limits import deepest, judged
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.media.relaxation import Relaxation
from flatpunch.media.tabulated import TabulatedMedium
from flatpunch.parallel.team import call_helpers

if TYPE_CHECKING:
    import xarray as xr

METHODS = {
    "first-order": "perturbation.first_order",
    "second-order": "perturbation.second_order",
    "fourth-order": "perturbation.fourth_order",
    "refined": "refined.method",
    "bem": "boundary_elements.method",
}
"""Contact methods by name: modules with `solve` (a whole curve) and `pressure` (one contact), loaded when first asked for."""

_VARIABLES = {
    "depth": ("m", "indentation depth"),
    "force": ("N", "normal force"),
    "radius": ("m", "mean contact radius a0"),
    "area": ("m^2", "contact area"),
    "stiffness": ("N/m", "contact stiffness dF/dd"),
}


@one_blas_thread()
@refused_overflow()
def indent(
    medium: Any,
    indenter: Indenter,
    *,
    depth: float | Array | None = None,
    force: float | Array | None = None,
    radius: float | Array | None = None,
    method: str | None = None,
    angles: int = 360,
    work_of_adhesion: float | None = None,
    range_of_action: float | None = None,
    time: Array | None = None,
    relaxation: Relaxation | None = None,
    **options: Any,
) -> xr.Dataset:
    """Press an indenter into a medium: a whole curve in one call.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    indenter : Indenter
        The rigid indenter.
    depth, force, radius : float or array, shape (n,)
        Exactly one: indentation depth [m], normal force [N], or mean contact radius a0 [m].
    method : str, optional
        "first-order": the paper's method. "second-order": exact perturbation theory, any shape. "fourth-order": the same for
        power-law shapes, far closer. "refined": round contacts corrected by a few boundary element solutions. "bem":
        boundary elements. All are exact for round indenters except "bem". By default the one that measured best for its
        cost, `default_method`.
    angles : int
        Number of polar angles of the outline, evenly spaced from 0.
    work_of_adhesion : float, optional
        [J/m^2]: JKR contact of a round indenter. Depth and force may then be negative; see `flatpunch.contact.adhesion.method`.
    range_of_action : float, optional
        Gap up to which adhesion acts [m]: adds a note where JKR theory does not hold for it.
    time : array, shape (n,), optional
        Times [s], ascending: depth or force is then a history, linear in between; see `flatpunch.contact.viscoelastic`.
    relaxation : Relaxation, optional
        psi(t) of the medium, e.g. Prony(...); goes with `time`.
    **options
        Further settings of the method.

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force [N], radius (a0) [m], area [m^2], stiffness dF/dd [N/m], valid (False where the
        theory does not hold) and contour(step, phi) [m]. The attributes say what was solved, and in `notes` with which
        limits.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.
    """
    if method is None and work_of_adhesion is not None:
        # adhesion is known to second order
        method = "second-order"
    if time is not None or relaxation is not None:
        given = {"depth": depth, "force": force, "radius": radius, "work_of_adhesion": work_of_adhesion}
        return _history(medium, indenter, given, time, relaxation, method or _best(indenter), angles, options)
    if work_of_adhesion is not None:
        work_of_adhesion = positive("work_of_adhesion", work_of_adhesion, unit="J/m**2")
        if range_of_action is not None:
            range_of_action = positive("range_of_action", range_of_action, unit="m")
        solver, method = adhesive_method(method or "second-order", indenter), method or "second-order"
        control = _module("adhesion.method").adhesive_control(depth=depth, force=force, radius=radius)
        phi = _angles(angles, control)
        curve = solver.solve(compliance(medium), indenter, control, phi, work_of_adhesion, range_of_action, **options)
        result = _dataset(curve, phi, medium, indenter, control, method)
        ranges = {} if range_of_action is None else {"range_of_action": range_of_action}
        return result.assign_attrs(work_of_adhesion=work_of_adhesion, **ranges)
    control = control_from(depth=depth, force=force, radius=radius)
    if method == "refined" and not getattr(indenter, "round", True):
        _load_beside(medium, indenter, control)
    solver, kernel, method = _solver(method, medium, indenter, control)
    phi = _angles(angles, control)
    _known(options, _module(METHODS[method]).solve, method)
    curve = solver.solve(kernel, indenter, control, phi, **options)
    return _dataset(curve, phi, medium, indenter, control, method)


@one_blas_thread()
@refused_overflow()
def pressure(
    medium: Any,
    indenter: Indenter,
    x: float | Array,
    y: float | Array,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    method: str | None = None,
    work_of_adhesion: float | None = None,
    **options: Any,
) -> Array:
    """Contact pressure p(x, y) at one depth, force or mean radius.

    Parameters
    ----------
    medium, indenter, method
        As for `indent`.
    x, y : float or array
        Points on the surface [m] about the point of first touch, broadcast together.
    depth, force, radius : float
        Exactly one of them.
    work_of_adhesion : float, optional
        [J/m^2]: with adhesion the pressure at the edge is minus infinity.

    Returns
    -------
    ndarray
        Pressure [Pa], zero outside the contact, in the broadcast shape of x and y.
    """
    if work_of_adhesion is None:
        control = control_from(depth=depth, force=force, radius=radius)
        solver, kernel, method = _solver(method, medium, indenter, control)
        _known(options, _module(METHODS[method]).pressure, method)
    else:
        control = _module("adhesion.method").adhesive_control(depth=depth, force=force, radius=radius)
        solver, kernel = adhesive_method(method or "second-order", indenter), compliance(medium)
        options = {**options, "work": positive("work_of_adhesion", work_of_adhesion, unit="J/m**2")}
    if control.values.size != 1:
        raise ValueError(f"{control.name} has {control.values.size} values; a pressure field belongs to one of them.")
    x, y = np.broadcast_arrays(numbers("x", x, "m"), numbers("y", y, "m"))
    if control.name == "depth" and control.values[0] >= deepest(medium):
        raise ValueError(
            f"depth = {text(float(control.values[0]), 'm')} is more than the {text(deepest(medium), 'm')} of the "
            "layers on their rigid base: no tip gets there. Ask for less depth."
        )
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ValueError("x and y must be finite: points on the surface in metres.")
    field = solver.pressure(kernel, indenter, control, np.hypot(x, y).ravel(), np.arctan2(y, x).ravel(), **options)
    return np.asarray(field).reshape(x.shape)


def _solver(method: str | None, medium: Any, indenter: Indenter, control: Control) -> tuple[Any, Kernel, str]:
    """Module of the method asked for or chosen, the medium's kernel, and the method's name."""
    solver = _method(method or "first-order", indenter)
    kernel = compliance(medium)
    if method is None:
        method = _best(indenter, kernel, control)
        solver = _method(method, indenter)
    return solver, kernel, method


def _known(options: dict[str, Any], function: Any, method: str) -> None:
    """Refuse settings that the method does not have."""
    parameters = list(inspect.signature(function).parameters.values())
    settings = [p.name for p in parameters if p.default is not p.empty]
    if any(p.kind is p.VAR_KEYWORD for p in parameters):
        return
    for name, value in options.items():
        if name not in settings:
            have = f"it has {', '.join(settings)}" if settings else "it has none"
            raise TypeError(f"{name} = {shown(value)} is no setting of method {method!r}: {have}. Check the spelling.")


def default_method(
    indenter: Indenter,
    medium: Any = None,
    *,
    depth: float | Array | None = None,
    force: float | Array | None = None,
    radius: float | Array | None = None,
) -> str:
    """The method that measured best for its cost; arguments as for `indent`.

    "refined" where the corrections that come with the package answer the whole case, which takes medium and steps to tell:
    pyramids of 3, 4 and 6 sides and ellipses on one layer on a rigid base. Else "fourth-order" for power-law shapes and
    "second-order" for all others. Round indenters, for which all fast methods agree and are exact, take the first-order road,
    which is the shortest.
    """
    if medium is None:
        return _best(indenter)
    return _best(indenter, compliance(medium), control_from(depth=depth, force=force, radius=radius))


def _best(indenter: Indenter, kernel: Kernel | None = None, control: Control | None = None) -> str:
    if getattr(indenter, "round", False):
        return "first-order"
    if kernel is not None and control is not None and _module(METHODS["refined"]).covered(kernel, indenter, control):
        return "refined"
    return "second-order" if getattr(indenter, "exponent", None) is None else "fourth-order"


def _method(method: str, indenter: Indenter) -> Any:
    if isinstance(indenter, type) or not isinstance(indenter, Indenter):
        raise TypeError(
            f"indenter = {shown(indenter)} must be an indenter such as Paraboloid(radius=...) or Pyramid(sides=..., "
            "inclination=...)."
        )
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method = {shown(method)} is unknown; choose one of {', '.join(map(repr, METHODS))}.")
    return _module("round.cylinder" if isinstance(indenter, Cylinder) else METHODS[method])


def _module(name: str) -> Any:
    """A module of this package; all of them together take longer to load than most of them to answer."""
    return import_module(f"flatpunch.contact.{name}")


def _load_beside(medium: Any, indenter: Indenter, control: Control) -> None:
    """Let other processes load the refined method while this one does, where that has not been needed so far.

    What curves and results are made of is loaded while the others solve: later they would have nothing to do meanwhile.
    """
    if f"flatpunch.contact.{METHODS['refined']}" not in sys.modules:
        shared = medium, indenter
        later = "xarray", "scipy.interpolate"
        call_helpers("flatpunch.contact.refined.one_solution", shared, control.values.size, meanwhile=later)


def adhesive_method(method: str, indenter: Indenter) -> Any:
    """Return the module that solves adhesive contacts by this method, or refuse it."""
    _method(method, indenter)
    if method == "bem":
        raise ValueError("work_of_adhesion goes with the fast methods, not with method='bem'.")
    if method != "second-order" and not indenter.round:
        raise ValueError(
            f"method = {method!r} does not know adhesion of non-round tips; it is solved to second order: choose "
            "method='second-order'."
        )
    return _module("adhesion.method")


def _history(
    medium: Any,
    indenter: Indenter,
    given: dict[str, Any],
    time: Any,
    relaxation: Any,
    method: str,
    angles: int,
    options: dict[str, Any],
) -> xr.Dataset:
    """Viscoelastic contact: a history instead of a curve."""
    if given.pop("work_of_adhesion") is not None:
        raise ValueError(
            "work_of_adhesion and relaxation do not go together: adhesion of viscoelastic bodies is not solved."
        )
    if time is None or not isinstance(relaxation, Relaxation):
        raise ValueError(
            "time and relaxation go together: times [s] with a depth or force each, and the relaxation of the medium, e.g. "
            f"Prony(weights, times). Got time = {shown(time)}, relaxation = {shown(relaxation)}."
        )
    if method == "bem":
        raise ValueError("relaxation needs a whole elastic curve; choose a fast method or 'refined' instead of 'bem'.")
    viscoelastic = _module("viscoelastic")
    solver, control = _method(method, indenter), viscoelastic.history_control(**given)
    phi = _angles(angles, control)
    times = values("time", time, minimum=-np.inf, unit="s")
    curve = viscoelastic.solve(medium, indenter, control, times, relaxation, phi, solver.solve, options)
    result = _dataset(curve, phi, medium, indenter, control, method)
    return result.assign_attrs(relaxation=json.dumps(record(relaxation)))


def _angles(angles: int, control: Control) -> Array:
    count = whole("angles", angles, 1, "It is the number of polar angles of the outline.", most=ANGLES)
    check_outlines(count, control.values.size)
    return np.asarray(np.arange(count) * (2 * np.pi / count))


def check_outlines(angles: int, steps: int) -> None:
    """Refuse results whose outlines fill the memory."""
    if angles * steps > OUTLINES:
        raise ValueError(
            f"angles = {angles} times {steps} steps make {angles * steps:.3g} points of outlines; {OUTLINES:.0e} are the most. "
            "Take fewer angles, or solve the steps in parts."
        )


def _dataset(curve: Curve, phi: Array, medium: Any, indenter: Indenter, control: Control, method: str) -> xr.Dataset:
    curve = judged(curve, medium, indenter)
    data: dict[str, Column] = {
        name: ("step", getattr(curve, name), {"units": unit, "long_name": long_name})
        for name, (unit, long_name) in _VARIABLES.items()
    }
    data["contour"] = (("step", "phi"), curve.contour, {"units": "m", "long_name": "contact outline a(phi)"})
    data["valid"] = ("step", curve.valid, {"long_name": "whether the theory holds at this step"})
    for name, (dims, array, unit, long_name) in curve.extra.items():
        data[name] = (dims, array, {"units": unit, "long_name": long_name})
    coordinates = {
        "step": (np.arange(curve.depth.size), {"long_name": "step of the curve"}),
        "phi": (phi, {"units": "rad", "long_name": "polar angle"}),
    }
    attributes = {
        "title": "Indentation computed by flatpunch",
        "method": method,
        "control": control.name,
        "medium": json.dumps(record(medium)),
        "indenter": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
        "conventions": "SI units; pressure positive in compression; depth and gap as in the documentation",
        "notes": "\n".join(curve.notes),
    }
    if isinstance(medium, TabulatedMedium):
        attributes["flat_punches"] = medium.solution.told(curve.radius / medium.length)
    return dataset(data, coordinates, attributes)
