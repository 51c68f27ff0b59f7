"""`partial_slip`: a round contact that is pressed in, then pulled along the surface."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import (
    ROUNDING,
    STEPS,
    Array,
    BadValue,
    Flags,
    Indices,
    Values,
    positive,
    refused_overflow,
    values,
    whole,
)
from flatpunch._support.prefixes import text
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.tangential import tangential_response
from flatpunch.contact.curve import NOTABLE_FORCE, Curve, control_from, few, first_failure, percent
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.contact.limits import judged
from flatpunch.contact.methods import Exact
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.contact.round.soundness import soundness
from flatpunch.contact.round.superposition import NEAREST, grown_pressure
from flatpunch.contact.slip.partial_contact import PartialContact
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.punch.family import UnresolvedLayer
from flatpunch.punch.matrix import RESOLVED, effective_beta

if TYPE_CHECKING:
    import xarray as xr

_TANGENTIAL = {"tangential_force": "N", "stick_radius": "m", "displacement": "m"}

_COLUMNS = {
    "tangential_force": ("N", "force along the surface T"),
    "displacement": ("m", "displacement of the tip along the surface"),
    "stick_radius": ("m", "radius within which the surfaces stick; 0 where they slide"),
    "lateral_stiffness": ("N/m", "dT over d displacement, on loading"),
    "dissipated_energy": ("J", "energy lost in a cycle between this displacement and its opposite"),
    "error": ("", "estimated relative error of force and stiffness at given displacement"),
}


@one_blas_thread()
@refused_overflow()
def partial_slip(
    medium: Body,
    indenter: Indenter,
    *,
    friction: float,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
    tangential_force: Values | None = None,
    stick_radius: Values | None = None,
    displacement: Values | None = None,
    places: int = 0,
) -> xr.Dataset:
    """Pull a pressed round tip along the surface: it sticks in the middle and slips around (Cattaneo, Mindlin).

    The normal force is constant while the tangential one grows from zero. A tangential force of 0 gives the lateral stiffness
    under full stick, that of contact resonance and friction-force microscopy.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them, whose layers do not slide without friction.
    indenter : Indenter
        A round indenter, not a flat end.
    friction : float
        Coefficient of friction mu [-], > 0.
    depth, force, radius : float or array, shape (n,)
        Exactly one: indentation depth [m], normal force [N] or contact radius [m].
    tangential_force, stick_radius, displacement : float or array, shape (n,)
        Exactly one: force along the surface [N], at most mu times the normal one; radius of the stick zone [m], at most that of
        the contact; displacement of the tip along the surface [m], beyond full slip too. One value goes with many of the normal
        contact, and the other way round.
    places : int
        Number of radii, evenly spaced from the axis to the rim, at which pressure and traction are returned; 0 leaves them out.

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force [N], radius [m], tangential_force [N], displacement [m], stick_radius [m],
        lateral_stiffness [N/m], dissipated_energy [J] of a cycle between +/- this displacement, error (relative, of force and
        stiffness at given displacement: what moves across the force is left out) and valid. With `places` also pressure,
        traction and traction_error [Pa] over (step, place), place = r/radius: the traction along the force in the mean over the
        directions. Attributes say what was solved; `notes` with which limits.

    Raises
    ------
    ValueError, TypeError
        On bad input, for tips that are not round, and for bodies that nothing holds along the surface.

    See Also
    --------
    indent : The normal contact.
    fields : Stresses under a sliding tip.

    Notes
    -----
    On half-spaces exact within the theory of Cattaneo (1938) and Mindlin (1949): tractions act along the force alone, and do not
    change the pressure. Theory page 18 has what replaces the difference of two normal contacts on layers.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(young=5e9, poisson=0.3, thickness=1e-6)], base=fp.HalfSpace(young=1e9, poisson=0.3))
    >>> pulled = fp.partial_slip(film, fp.Sphere(radius=1e-3), friction=0.5, radius=2e-6, stick_radius=[1e-6, 0.0])
    >>> print((pulled.tangential_force / (0.5 * pulled.force)).values.round(3))
    [0.895 1.   ]
    """
    check_indenter(indenter)
    mu = positive("friction", friction, "It is the coefficient of friction.", unit="1")
    count = whole("places", places, 0, "It is the number of radii at which tractions are returned.", most=STEPS)
    check_tip(indenter)
    quantity, wanted = _prescribed(
        tangential_force=tangential_force, stick_radius=stick_radius, displacement=displacement
    )
    control = control_from(depth=depth, force=force, radius=radius)
    kernel, tangential = compliance(medium), tangential_response(medium)
    steps = _steps(control.name, control.values.size, quantity, wanted.size)
    curve = judged(Exact().solve(kernel, indenter, control, np.zeros(1)), medium, indenter)
    _check_size(tangential.kernel, curve.radius)
    wanted, row = np.broadcast_to(wanted, steps), np.broadcast_to(np.arange(control.values.size), steps)
    _check_most(quantity, wanted, curve, row, mu)
    profile, rho = mean_profile(indenter), np.arange(count) / max(count - 1, 1)
    found, tractions, sound = np.zeros((len(_COLUMNS), steps)), np.zeros((3, steps, count)), curve.valid[row]
    # within a flat end no force presses
    for i in np.flatnonzero(curve.force > 0):
        contact = PartialContact(kernel, tangential, profile, round_contact(kernel, profile, curve.radius[i : i + 1]))
        here = np.flatnonzero(row == i)
        found[:, here], held = _solved(contact, mu, quantity, wanted[here])
        sound[here] &= held
        if count:
            tractions[:, here] = _tractions(contact, mu, found[:, here], rho)
    notes = first_failure(
        ~sound & curve.valid[row],
        found[2],
        "slip does not spread from the rim alone, as the film bends: the stick zone is no disc, or was none before.",
        ("stick zone", "m"),
    )
    return _result(medium, indenter, mu, curve, row, found, sound, tractions, rho, notes)


def loading_and_cycle(result: xr.Dataset) -> tuple[Array, Array]:
    """Displacements [m] and tangential forces [N] of the first loading, and of the cycle of its largest displacement."""
    order = np.argsort(result["displacement"].values, kind="stable")
    columns = [result[name].values[order] for name in ("displacement", "tangential_force")]
    first = np.concatenate([np.zeros((2, 1)), columns], axis=1)
    # a cycle follows the first loading, twice as large (Masing)
    back = first[:, -1:] - 2 * first
    return first, np.concatenate([back, -back], axis=1)


def _check_size(kernel: Kernel, radius: Array) -> None:
    """Refuse contacts so wide that a layer is a skin."""
    largest = float(radius.max())
    if (over := effective_beta(kernel, largest / kernel.length)) > RESOLVED:
        raise UnresolvedLayer(
            f"The contact radius {text(largest, 'm')} is {over:.3g} times the shortest length of the medium; partial slip is "
            f"solved up to {RESOLVED:g} of them. Leave the thin layer out, or ask for a smaller contact."
        )


def check_tip(indenter: Indenter) -> None:
    """Refuse tips that are not round or have a flat end."""
    if indenter.flat:
        raise ValueError(
            f"indenter = {type(indenter).__name__} has a flat end, which sticks as a whole until it slides: it has no partial "
            "slip. Round its edge, RoundedPunch(...)."
        )
    if not indenter.round:
        raise ValueError(
            f"indenter = {type(indenter).__name__} is not round: partial slip is solved under round tips. Take the round tip "
            "with the same areas, as Cone(...) for a pyramid."
        )


def _prescribed(**given: object) -> tuple[str, Array]:
    """Name and values >= 0 of the one quantity along the surface that is given."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        raise ValueError(
            "Give exactly one of tangential_force, stick_radius and displacement; got "
            f"{' and '.join(names) or 'none'}. The other two are part of the result."
        )
    return names[0], few(names[0], values(names[0], given[names[0]], unit=_TANGENTIAL[names[0]]))


def _steps(normal: str, first: int, quantity: str, second: int) -> int:
    if first != second and 1 not in (first, second):
        raise BadValue(quantity, "", f"has {second} values and {normal} {first}; give as many, or one of either.")
    return max(first, second)


def _check_most(quantity: str, wanted: Array, curve: Curve, row: Indices, mu: float) -> None:
    """Refuse forces beyond friction, and stick radii beyond the contact."""
    if quantity == "displacement":
        return
    most, unit, what = (
        (mu * curve.force[row], "N", "friction times the normal force")
        if quantity == "tangential_force"
        else (curve.radius[row], "m", "the radius of the contact")
    )
    beyond = np.flatnonzero(wanted > most * (1 + ROUNDING))
    if beyond.size:
        i = beyond[0]
        raise BadValue(
            f"{quantity}[{i}]",
            text(float(wanted[i]), unit),
            f"exceeds {what}, {text(float(most[i]), unit)}, at which the contact slides as a whole. Ask for less, or prescribe "
            "displacement.",
        )


def _solved(contact: PartialContact, mu: float, quantity: str, wanted: Array) -> tuple[Array, Flags]:
    """Rows of `_COLUMNS` for values of one quantity along the surface, shape (6, n), and where the stick zone is sound."""
    ratio, most, sliding = contact.tangential.ratio, mu * contact.force, mu * contact.tangential.ratio * contact.sliding
    if quantity == "stick_radius":
        stick = np.minimum(wanted, contact.radius)
    else:
        stick = contact.stick_radius(quantity, wanted / (mu if quantity == "tangential_force" else mu * ratio))
    # a flat end without any force left slides as a whole
    stick = np.where(contact.sticking(stick).force == 0, 0.0, stick)
    held = contact.sticking(stick)
    pulled = np.maximum(most - mu * held.force, 0.0)
    moved = np.maximum(sliding - mu * ratio * held.depth, 0.0)
    beyond = np.zeros_like(moved)
    if quantity == "tangential_force":
        pulled = wanted
    if quantity == "displacement":
        beyond, moved = np.maximum(wanted - sliding, 0.0), np.minimum(wanted, sliding)
    # Masing: a cycle follows the first loading, twice as large
    lost = 8 * (mu**2 * ratio * contact.work(stick) - pulled * moved / 2) + 4 * most * beyond
    live = stick > 0
    sound = stick >= contact.turning
    if live.any():
        sound[live] &= soundness(contact.tangential.kernel, contact.sticking, contact.sticking(stick[live]))[0]
    stiffness = held.stiffness / ratio
    return np.stack([pulled, moved + beyond, stick, stiffness, np.maximum(lost, 0.0), contact.error(stick)]), sound


def _tractions(contact: PartialContact, mu: float, found: Array, rho: Array) -> Array:
    """Pressure, traction and its error [Pa] at shares rho of the radius, for rows of `_COLUMNS`; shape (3, n, places).

    The error is that of both pressures, the traction of a contact that sticks as a whole, which is none, the change in the
    disturbed contacts, and the share of the traction that is lost along the force or at given displacement.
    """
    # sharp tips have infinite pressures on the axis, whose difference is finite
    r = np.maximum(rho, NEAREST) * contact.radius
    _, displacement, stick, *_, relative = found
    normal, unsure = grown_pressure(
        contact.kernel, lambda a: round_contact(contact.kernel, contact.profile, a), contact.radius, r
    )
    by, share = displacement / (mu * contact.tangential.ratio), relative + contact.lost
    whole = 0.0 if contact.alike else np.abs(normal - _held(contact, contact.radius, r)[0])
    result = []
    for c, delta, e, part in zip(stick, by, relative, share, strict=True):
        own, error = _held(contact, c, r)
        traction = mu * (normal - own)
        for pair in contact.disturbed(c, delta, e):
            error = error + np.abs([_held(other, radius, r)[0] - own for other, radius in pair]).max(axis=0)
        error = mu * (unsure + error + whole) + part * np.abs(traction)
        result.append((normal, traction, error))
    return np.array(result).swapaxes(0, 1)


def _held(contact: PartialContact, stick: float, r: Array) -> tuple[Array, Array]:
    """p' of a stick radius at distances r, and its error; shape (n,) each [Pa]."""
    return grown_pressure(contact.tangential.kernel, contact.sticking, float(stick), r)


def _result(
    medium: Body,
    indenter: Indenter,
    mu: float,
    curve: Curve,
    row: Indices,
    found: Array,
    sound: Flags,
    tractions: Array,
    rho: Array,
    notes: tuple[str, ...],
) -> xr.Dataset:
    data: dict[str, Column] = {
        name: ("step", getattr(curve, name)[row], {"units": unit, "long_name": what})
        for name, unit, what in (
            ("depth", "m", "indentation depth"),
            ("force", "N", "normal force"),
            ("radius", "m", "contact radius"),
        )
    }
    for (name, (unit, what)), column in zip(_COLUMNS.items(), found, strict=True):
        data[name] = ("step", column, {"units": unit, "long_name": what})
    data["valid"] = ("step", sound, {"long_name": "whether the theory holds at this step"})
    coordinates: dict[str, tuple[NDArray[np.generic], Attributes]] = {
        "step": (np.arange(row.size), {"long_name": "step"})
    }
    if rho.size:
        coordinates["place"] = (rho, {"long_name": "distance from the axis over the contact radius"})
        names = {"pressure": "pressure", "traction": "traction", "traction_error": "estimated error of the traction"}
        for (name, what), field in zip(names.items(), tractions, strict=True):
            data[name] = (("step", "place"), field, {"units": "Pa", "long_name": f"{what} on the contact"})
    large = found[5] > NOTABLE_FORCE
    notes += first_failure(
        large,
        found[1],
        f"force and stiffness are expected to be off by up to {percent(float(found[5].max()))}, as the surface also moves "
        "across the force.",
        ("displacement", "m"),
    )
    attributes = {
        "title": "Partial slip computed by flatpunch",
        "friction": mu,
        "medium": json.dumps(record(medium)),
        "indenter": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
        "notes": "\n".join((*curve.notes, *notes)),
    }
    return dataset(data, coordinates, attributes)
