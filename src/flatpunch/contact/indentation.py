"""`indent` and `pressure`: one front for every medium, indenter and method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NotRequired, TypedDict, Unpack, overload

import numpy as np

from flatpunch._support.checks import NUMBERS, Array, Values, numbers, refused_overflow, switch
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import compliance
from flatpunch.contact.curve import PressureField, control_from
from flatpunch.contact.default import (
    Method,
    MethodName,
    asked_for,
    check_membrane,
    choose,
    method_of,
    series_of,
    solver_of,
)
from flatpunch.contact.finite_strain.correction import checked as finite_strain_place
from flatpunch.contact.finite_strain.correction import solve as finite_strain_curve
from flatpunch.contact.histories import control_with, history, on_free_layer, sticking
from flatpunch.contact.limits import check_deepest
from flatpunch.contact.methods import BoundaryElements, Exact, Refined, exactly_solved
from flatpunch.contact.physics import FiniteStrain, Physics, PhysicsOf
from flatpunch.contact.result import outline_angles, result_of
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, underlying
from flatpunch.media.relaxation import Relaxation
from flatpunch.numerics.shapes import common_shape

if TYPE_CHECKING:
    import xarray as xr


class Options(PhysicsOf, total=False):
    """Arguments of `indent` that go with depths, forces and radii alike."""

    method: MethodName | Method | None
    angles: int


class History(TypedDict):
    """Arguments of `indent` that go with histories of depths and forces."""

    time: Values
    relaxation: Relaxation | Sequence[Relaxation | None]
    method: NotRequired[MethodName | Method | None]
    angles: NotRequired[int]


class Place(TypedDict, total=False):
    """Arguments of `pressure` besides body, tip and points."""

    depth: float | None
    force: float | None
    radius: float | None
    method: MethodName | Method | None
    work_of_adhesion: float | None
    range_of_action: float | None
    strength: float | None


@overload
def indent(medium: Body, indenter: Indenter, *, depth: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, force: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, radius: Values, **options: Unpack[Options]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, depth: Values, **history: Unpack[History]) -> xr.Dataset: ...
@overload
def indent(medium: Body, indenter: Indenter, *, force: Values, **history: Unpack[History]) -> xr.Dataset: ...
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
    strength: float | None = None,
    time: Values | None = None,
    relaxation: Relaxation | Sequence[Relaxation | None] | None = None,
    finite_strain: FiniteStrain | None = None,
) -> xr.Dataset:
    """Press an indenter into a medium: a whole curve in one call.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them; or a FreeLayer, which lifts off its base.
    indenter : Indenter
        The rigid indenter.
    depth, force, radius : float or array, shape (n,)
        Exactly one: indentation depth [m], normal force [N], or mean contact radius a0 [m].
    method : str or method, optional
        `Exact()`, "exact": round tips on every medium, elliptic paraboloids on half-spaces. `FirstOrder()`, "first-order": the
        paper's method. `SecondOrder()`, "second-order": exact perturbation theory, any
        shape. `FourthOrder()`, "fourth-order": the same for power-law shapes, far closer. `Refined(...)`, "refined": round
        contacts corrected by a few boundary element solutions. `BoundaryElements(...)`, "bem": boundary elements. All are
        exact for round indenters except boundary elements. By default the one that measured best for its cost,
        `default_method`.
    angles : int
        Number of polar angles of the outline, evenly spaced from 0.
    work_of_adhesion : float, optional
        [J/m^2]: adhesive contact after JKR, or with a range of action. Depth and force may then be negative; see
        `flatpunch.contact.adhesion.method`.
    range_of_action : float, optional
        Largest gap z0 across which adhesion acts [m], with the stress w/z0 (Maugis-Dugdale); see `pull_off`. The result has the
        radius within which it acts, `adhesive_radius`.
    strength : float, optional
        In its place the adhesive stress w/z0 [Pa].
    time : array, shape (n,), optional
        Times [s], ascending: depth or force is then a history, linear in between; see `flatpunch.contact.viscoelastic`.
    relaxation : Relaxation, or sequence of Prony, StandardLinearSolid or None, optional
        psi(t) of the medium, e.g. Prony(...); goes with `time`. Under round tips a list gives one for each layer from the surface
        down and for the base, None for what is elastic. Springs of interfaces are elastic in a list, and relax with the layers
        otherwise.
    finite_strain : {"neo-hookean"}, optional
        Corrects forces and stiffnesses for large strains, on a half-space or one bonded layer on a rigid base, at depths up to
        half of the thickness and Poisson ratios from 0.4 on: under a Sphere (on half-spaces down to its radius), a Cone of 10 to
        60 degrees and a SpheroCone. Under sharp pyramids it is estimated by the cone with the same areas. The result
        has `strain_factor`, force over that of linear theory, and its error in `force_error`; radius, area and contour are those
        of linear theory.

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force [N], radius (a0) [m], area [m^2], stiffness dF/dd [N/m], valid (False where the
        theory does not hold) and contour(step, phi) [m], which is absent if no contact has an outline, as those in several
        parts. The attributes say what was solved (`method` and its `method_settings` among them), and in `notes` with which
        limits.

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
    given = {"depth": depth, "force": force, "radius": radius}
    name = next((each for each, values in given.items() if values is not None), "depth")
    physics = Physics(work_of_adhesion, range_of_action, strength, relaxation, finite_strain)
    large = finite_strain_place(physics, medium, indenter, name)
    if loose := underlying(medium).free:
        return on_free_layer(loose, indenter, given, chosen, angles, {"time": time, **physics.given})
    if time is not None or relaxation is not None:
        return history(medium, indenter, given, time, physics, chosen, angles)
    if physics.work_of_adhesion is not None:
        return sticking(medium, indenter, given, physics, chosen, angles)
    control = control_from(**given)
    phi, kernel = outline_angles(angles, control), compliance(medium, membrane=True)
    choice = choose(kernel, indenter, control, phi) if chosen is None else asked_for(chosen, indenter)
    solver = solver_of(choice.method, indenter)
    check_membrane(medium, kernel, solver)
    if large is not None:
        curve = finite_strain_curve(large, lambda each: solver.solve(kernel, indenter, each, phi), control)
        # a method is exact for linear theory alone
        reason = f"{'round tip' if indenter.round else choice.reason}, forces at large strain from a table"
        result = result_of(curve, phi, medium, indenter, control, choice)
        return result.assign_attrs(finite_strain=finite_strain, method_reason=reason)
    curve = choice.curve or solver.solve(kernel, indenter, control, phi)
    return result_of(curve, phi, medium, indenter, control, choice)


@overload
def pressure(
    medium: Body,
    indenter: Indenter,
    x: Values,
    y: Values,
    *,
    return_error: Literal[False] = False,
    **place: Unpack[Place],
) -> Array: ...
@overload
def pressure(
    medium: Body, indenter: Indenter, x: Values, y: Values, *, return_error: Literal[True], **place: Unpack[Place]
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
    range_of_action: float | None = None,
    strength: float | None = None,
    return_error: bool = False,
) -> Array | tuple[Array, Array]:
    """Contact pressure p(x, y) at one depth, force or mean radius.

    Exact where `indent` is. Under all others it comes from boundary elements, whatever the method: perturbation theory gives
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
    range_of_action : float, optional
        Range of adhesion z0 [m]: the pressure is then -work_of_adhesion/z0 from the edge of the contact on, across the gap.
    strength : float, optional
        In its place that stress [Pa].
    return_error : bool
        Whether the estimated error of each value is returned as well.

    Returns
    -------
    pressure : ndarray
        Pressure [Pa], zero where surfaces do not act on one another, in the broadcast shape of x and y. At the apex of a sharp
        round tip it is infinite; closer to it than 1e-7 of the radius it is given as at that distance, and so is its error.
    error : ndarray
        Estimated error of each value [Pa], if `return_error`: what cells twice as wide change, by a second solution, at a given
        radius of its depth too, and the difference to boundary elements for "first-order". Errors are larger within a cell of
        edges, where the pressure is infinite, and beyond ends of the contact that are narrower than a cell.

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
    physics = Physics(work_of_adhesion, range_of_action, strength)
    control = control_with(physics, chosen, indenter, depth=depth, force=force, radius=radius)
    if control.values.size != 1:
        raise ValueError(f"{control.name} has {control.values.size} values; a pressure field belongs to one of them.")
    return_error = switch("return_error", return_error)
    x, y = numbers("x", x, "m"), numbers("y", y, "m")
    points = math.prod(common_shape(x=x, y=y))
    if points > NUMBERS:
        raise ValueError(f"x and y make {points} points; give at most {NUMBERS} in one call.")
    x, y = np.broadcast_arrays(x, y)
    if control.name == "depth":
        check_deepest(medium, float(control.values[0]))
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ValueError("x and y must be finite: points on the surface in metres.")
    r, phi = np.hypot(x, y).ravel(), np.arctan2(y, x).ravel()
    kernel = compliance(medium, membrane=physics.work_of_adhesion is None)
    if physics.work_of_adhesion is not None:
        from flatpunch.contact.adhesion.method import pressure as adhesive_pressure

        adhesion = physics.work_of_adhesion, physics.within
        with physics.named():
            field = PressureField(*adhesive_pressure(kernel, indenter, control, r, *adhesion))
    else:
        # all methods have the same pressure but for the depth that belongs to a mean radius
        if exactly_solved(kernel, indenter):
            default: Method = Exact()
        else:
            series = series_of(indenter)
            refined = control.name == "radius" and not isinstance(series, BoundaryElements)
            default = Refined() if refined else series
        solver = solver_of(chosen or (default if kernel.limit == 1 else BoundaryElements()), indenter)
        check_membrane(medium, kernel, solver)
        field = solver.pressure(kernel, indenter, control, r, phi)
    values = field.pressure.reshape(x.shape)
    return (values, field.error.reshape(x.shape)) if return_error else values
