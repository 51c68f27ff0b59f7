"""`indent` and `pressure`: one front for every medium, indenter and method."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack, overload

import numpy as np

from flatpunch._support.ceilings import ANGLES, OUTLINES
from flatpunch._support.checks import Array, Values, numbers, positive, shown, switch, values, whole
from flatpunch._support.overflow import refused_overflow
from flatpunch._support.prefixes import text
from flatpunch._support.record import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control, Curve, control_from, uncertain
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.default import Choice, adhesive_method, asked_for, choose, series_of
from flatpunch.contact.limits import deepest, judged
from flatpunch.contact.methods import (
    BoundaryElements,
    Method,
    MethodName,
    Refined,
    method_of,
    solver_of,
)
from flatpunch.contact.pressure_field import exact
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.media.relaxation import Relaxation
from flatpunch.media.tabulated import TabulatedMedium

if TYPE_CHECKING:
    import xarray as xr

_VARIABLES = {
    "depth": ("m", "indentation depth"),
    "force": ("N", "normal force"),
    "radius": ("m", "mean contact radius a0"),
    "area": ("m^2", "contact area"),
    "stiffness": ("N/m", "contact stiffness dF/dd"),
}


class Options(TypedDict, total=False):
    """Arguments of `indent` that go with depths, forces and radii alike."""

    method: MethodName | Method | None
    angles: int
    work_of_adhesion: float | None
    range_of_action: float | None


@overload
def indent(medium: Body, indenter: Indenter, *, depth: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, force: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, radius: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(
    medium: Body,
    indenter: Indenter,
    *,
    depth: Values,
    time: Values,
    relaxation: Relaxation,
    method: MethodName | Method | None = None,
    angles: int = 360,
) -> xr.Dataset: ...
@overload
def indent(
    medium: Body,
    indenter: Indenter,
    *,
    force: Values,
    time: Values,
    relaxation: Relaxation,
    method: MethodName | Method | None = None,
    angles: int = 360,
) -> xr.Dataset: ...
@one_blas_thread()
@refused_overflow()
def indent(
    medium: Body,
    indenter: Indenter,
    *,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
    method: MethodName | Method | None = None,
    angles: int = 360,
    work_of_adhesion: float | None = None,
    range_of_action: float | None = None,
    time: Values | None = None,
    relaxation: Relaxation | None = None,
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
    method : str or method, optional
        `FirstOrder()`, "first-order": the paper's method. `SecondOrder()`, "second-order": exact perturbation theory, any
        shape. `FourthOrder()`, "fourth-order": the same for power-law shapes, far closer. `Refined(...)`, "refined": round
        contacts corrected by a few boundary element solutions. `BoundaryElements(...)`, "bem": boundary elements. All are
        exact for round indenters except boundary elements. By default the one that measured best for its cost,
        `default_method`.
    angles : int
        Number of polar angles of the outline, evenly spaced from 0.
    work_of_adhesion : float, optional
        [J/m^2]: JKR contact of a round indenter. Depth and force may then be negative; see `flatpunch.contact.adhesion.method`.
    range_of_action : float, optional
        Largest gap across which adhesion acts [m]: adds a note where JKR theory does not hold for it.
    time : array, shape (n,), optional
        Times [s], ascending: depth or force is then a history, linear in between; see `flatpunch.contact.viscoelastic`.
    relaxation : Relaxation, optional
        psi(t) of the medium, e.g. Prony(...); goes with `time`.

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force [N], radius (a0) [m], area [m^2], stiffness dF/dd [N/m], valid (False where the
        theory does not hold) and contour(step, phi) [m]. The attributes say what was solved (`method` and its
        `method_settings` among them), and in `notes` with which limits.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    pressure : The pressure of one contact.
    pull_off : Where an adhesive contact is lost.
    fit : From a measured curve to moduli.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> curve = fp.indent(gel, fp.Sphere(radius=5e-6), depth=[100e-9, 200e-9])
    >>> print([f"{force * 1e9:.2f} nN" for force in curve.force.values])
    ['1.96 nN', '8.92 nN']
    """
    check_indenter(indenter)
    chosen = None if method is None else method_of(method)
    if time is not None or relaxation is not None:
        given = {"depth": depth, "force": force, "radius": radius, "work_of_adhesion": work_of_adhesion}
        return _history(medium, indenter, given, time, relaxation, chosen, angles)
    if work_of_adhesion is not None:
        from flatpunch.contact.adhesion import method as adhesive

        work_of_adhesion = positive("work_of_adhesion", work_of_adhesion, unit="J/m**2")
        if range_of_action is not None:
            range_of_action = positive("range_of_action", range_of_action, unit="m")
        chosen = adhesive_method(chosen, indenter)
        control = adhesive.adhesive_control(depth=depth, force=force, radius=radius)
        phi = _angles(angles, control)
        curve = adhesive.solve(compliance(medium), indenter, control, phi, work_of_adhesion, range_of_action)
        result = _dataset(curve, phi, medium, indenter, control, asked_for(chosen, indenter))
        ranges = {} if range_of_action is None else {"range_of_action": range_of_action}
        return result.assign_attrs(work_of_adhesion=work_of_adhesion, **ranges)
    control = control_from(depth=depth, force=force, radius=radius)
    phi, kernel = _angles(angles, control), compliance(medium)
    choice = choose(kernel, indenter, control, phi) if chosen is None else asked_for(chosen, indenter)
    curve = choice.curve or solver_of(choice.method, indenter).solve(kernel, indenter, control, phi)
    return _dataset(curve, phi, medium, indenter, control, choice)


@overload
def pressure(
    medium: Body,
    indenter: Indenter,
    x: Values,
    y: Values,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    method: MethodName | Method | None = None,
    work_of_adhesion: float | None = None,
    return_error: Literal[False] = False,
) -> Array: ...
@overload
def pressure(
    medium: Body,
    indenter: Indenter,
    x: Values,
    y: Values,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    method: MethodName | Method | None = None,
    work_of_adhesion: float | None = None,
    return_error: Literal[True],
) -> tuple[Array, Array]: ...
@one_blas_thread()
@refused_overflow()
def pressure(
    medium: Body,
    indenter: Indenter,
    x: Values,
    y: Values,
    *,
    depth: float | None = None,
    force: float | None = None,
    radius: float | None = None,
    method: MethodName | Method | None = None,
    work_of_adhesion: float | None = None,
    return_error: bool = False,
) -> Array | tuple[Array, Array]:
    """Contact pressure p(x, y) at one depth, force or mean radius.

    Exact under round indenters. Under all others it comes from boundary elements, whatever the method: perturbation theory gives
    force and outline, and no pressure. Only "first-order" superposes the pressures of stretched flat punches, as Forsbach and
    Willert do; they are compared with boundary elements, and a warning states the difference.

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
    return_error : bool
        Whether the estimated error of each value is returned as well.

    Returns
    -------
    pressure : ndarray
        Pressure [Pa], zero outside the contact, in the broadcast shape of x and y.
    error : ndarray
        Estimated error of each value [Pa], if `return_error`: what cells twice as wide would change, and the difference to
        boundary elements for "first-order".

    See Also
    --------
    indent : Force and outline.
    fields : Stresses inside the body.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> print(f"{float(fp.pressure(gel, tip, 0.0, 0.0, depth=100e-9)):.4g} Pa")
    600.9 Pa
    """
    check_indenter(indenter)
    chosen = None if method is None else method_of(method)
    if work_of_adhesion is None:
        control = control_from(depth=depth, force=force, radius=radius)
    else:
        from flatpunch.contact.adhesion import method as adhesive

        adhesive_method(chosen, indenter)
        control = adhesive.adhesive_control(depth=depth, force=force, radius=radius)
        work_of_adhesion = positive("work_of_adhesion", work_of_adhesion, unit="J/m**2")
    if control.values.size != 1:
        raise ValueError(f"{control.name} has {control.values.size} values; a pressure field belongs to one of them.")
    return_error = switch("return_error", return_error)
    x, y = numbers("x", x, "m"), numbers("y", y, "m")
    try:
        x, y = np.broadcast_arrays(x, y)
    except ValueError:
        raise ValueError(
            f"x and y have shapes {x.shape} and {y.shape}; they must be equal or broadcast to one another."
        ) from None
    if control.name == "depth" and control.values[0] >= deepest(medium):
        raise ValueError(
            f"depth = {text(float(control.values[0]), 'm')} is more than the {text(deepest(medium), 'm')} of the "
            "layers on their rigid base: no tip gets there. Ask for less depth."
        )
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ValueError("x and y must be finite: points on the surface in metres.")
    r, phi, kernel = np.hypot(x, y).ravel(), np.arctan2(y, x).ravel(), compliance(medium)
    if work_of_adhesion is not None:
        field = exact(adhesive.pressure(kernel, indenter, control, r, phi, work=work_of_adhesion), kernel, indenter)
    else:
        # all methods have the same pressure but for the depth that belongs to a mean radius
        default = Refined() if control.name == "radius" and not indenter.round else series_of(indenter)
        field = solver_of(chosen or default, indenter).pressure(kernel, indenter, control, r, phi)
    values = field.pressure.reshape(x.shape)
    return (values, field.error.reshape(x.shape)) if return_error else values


def _history(
    medium: Any,
    indenter: Indenter,
    given: dict[str, Any],
    time: Any,
    relaxation: Any,
    method: Method | None,
    angles: int,
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
    if isinstance(method, BoundaryElements):
        raise ValueError("relaxation needs a whole elastic curve; choose a fast method or 'refined' instead of 'bem'.")
    from flatpunch.contact import viscoelastic

    control = viscoelastic.history_control(**given)
    phi = _angles(angles, control)
    times = values("time", time, minimum=-np.inf, unit="s")
    if method is None:
        # judged at the largest depth or force, as if the body did not relax
        viscoelastic.check_medium(medium)
        largest = Control(control.name, np.maximum(control.values.max(keepdims=True), 0.0))
        choice = choose(compliance(medium), indenter, largest, phi)
    else:
        choice = asked_for(method, indenter)
    solve = solver_of(choice.method, indenter).solve
    curve = viscoelastic.solve(medium, indenter, control, times, relaxation, phi, solve)
    result = _dataset(curve, phi, medium, indenter, control, choice)
    return result.assign_attrs(relaxation=json.dumps(record(relaxation)))


def _why(choice: Choice) -> tuple[str, ...]:
    """A note where the default is not the fast method."""
    if choice.quick or choice.reason == "asked for":
        return ()
    return (f"Method {choice.method.name!r} was chosen, as {choice.reason}.",)


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


def _dataset(curve: Curve, phi: Array, medium: Any, indenter: Indenter, control: Control, choice: Choice) -> xr.Dataset:
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
        "method": choice.method.name,
        "method_settings": json.dumps(
            {k: v for k, v in record(choice.method).items() if k not in ("type", "progress")}
        ),
        "method_reason": choice.reason,
        "control": control.name,
        "medium": json.dumps(record(medium)),
        "indenter": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
        "conventions": "SI units; pressure positive in compression; depth and gap as in the documentation",
        "notes": "\n".join((*_why(choice), *curve.notes, *uncertain(curve))),
    }
    if isinstance(medium, TabulatedMedium):
        attributes["flat_punches"] = medium.solution.summary(curve.radius / medium.length)
    return dataset(data, coordinates, attributes)
