"""The loop of approach and withdrawal of an adhesive contact, and the energy that it loses.

Adhesion acts from the gap z0 on, its range of action: at d = -z0 under prescribed depth (0 in JKR theory), or F = 0 under
prescribed force, the contact jumps in to its first stable radius. It then follows stable stretches, jumping outwards where one
ends (under stiff films), and on the way back inwards, until it is lost. With the energy of a contact against separated bodies,

    E = U - pi a^2 w,      U = U_n(a) - F_n D + K D^2/2,      U_n = int F_n dd_n,

and dE = F dd along the branch with a range of action, a jump at fixed depth loses the difference of E, one at fixed force that of
E - F d. Pull-off is taken at fixed depth under either control (the machine stops while the contact is lost). The losses add up to
the area of the loop.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import STEPS, Array, positive, refused_overflow, whole
from flatpunch._support.paths import Plain
from flatpunch._support.readable import record
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.case import AdhesiveCase, adhesive_case, ends_of, radius_on, value_of
from flatpunch.contact.adhesion.pull_off import Instability
from flatpunch.contact.adhesion.stability import Quantity, Stretch
from flatpunch.contact.curve import UNITS
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.limits import check_deepest
from flatpunch.contact.physics import Physics
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.numerics.gauss import gauss

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, slots=True)
class Jump:
    """A sudden change of the contact.

    Attributes
    ----------
    kind : str
        "jump_in", "outwards", "inwards" or "pull_off".
    depth, force : float
        State before it [m], [N]; for jump-in the state after it.
    radius_before, radius_after : float
        Contact radii [m]; 0 for separated bodies.
    energy : float
        Energy lost [J].
    """

    kind: str
    depth: float
    force: float
    radius_before: float
    radius_after: float
    energy: float


@dataclass(frozen=True, slots=True)
class _Leg:
    """A stretch followed from one value of the control to another; None: pinned at the edge of a flat end."""

    stretch: Stretch | None
    start: float
    end: float


@one_blas_thread()
@refused_overflow()
def adhesion_loop(
    medium: Body,
    indenter: Indenter,
    *,
    work_of_adhesion: float,
    depth: float | None = None,
    force: float | None = None,
    points: int = 200,
    range_of_action: float | None = None,
    strength: float | None = None,
) -> xr.Dataset:
    """Approach to a largest depth or force, and withdrawal until the contact is lost.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    indenter : Indenter
        A round indenter, exact, or a power law such as a pyramid, to second order.
    work_of_adhesion : float
        Work of adhesion w [J/m^2].
    depth, force : float
        Exactly one: largest depth [m] or force [N], > 0; the same quantity is the one the machine prescribes.
    points : int
        Number of steps on each stretch of the way.
    range_of_action : float, optional
        Largest gap z0 of the adhesive stress [m]: Maugis-Dugdale theory in the place of JKR, as in `pull_off`.
    strength : float, optional
        In its place the adhesive stress [Pa].

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force [N], radius [m], area [m^2], and branch (0 approach, 1 withdrawal). Attributes:
        energy_lost [J]; jump_in_* and pull_off_* (depth [m], force [N], radius [m], energy [J]); `jumps`, a JSON list of
        all jumps in their order.

    Raises
    ------
    ValueError
        On bad input.

    See Also
    --------
    pull_off : Where the contact is lost.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> loop = fp.adhesion_loop(gel, fp.Sphere(radius=5e-6), work_of_adhesion=1e-5, depth=50e-9)
    >>> loop.attrs["energy_lost"] > 0
    True
    """
    if (depth is None) == (force is None):
        raise ValueError("Give exactly one of depth and force: the largest value of what the machine prescribes.")
    quantity: Quantity = "depth" if force is None else "force"
    most = positive(quantity, depth if force is None else force, unit=UNITS[quantity])
    count = whole("points", points, 2, "It is the number of steps on each stretch of the way.", most=STEPS)
    if quantity == "depth":
        check_deepest(medium, most)
    physics = Physics(work_of_adhesion, range_of_action, strength)
    with physics.named():
        case = adhesive_case(compliance(medium), indenter, work_of_adhesion, physics.within)
        approach, back, jumps = _path(case, quantity, most)
    attributes: Plain = {
        "title": "Adhesive approach and withdrawal computed by flatpunch",
        "control": quantity,
        "work_of_adhesion": case.branch.work,
        "energy_lost": sum(jump.energy for jump in jumps),
        "jumps": json.dumps([asdict(jump) for jump in jumps]),
        "medium": json.dumps(record(medium)),
        "indenter": json.dumps(record(indenter)),
        "flatpunch_version": __version__,
        "notes": "",
    }
    if physics.within is not None:
        attributes["range_of_action"] = physics.within
    for jump in (jumps[0], jumps[-1]):
        radius = max(jump.radius_before, jump.radius_after)
        values = {"depth": jump.depth, "force": jump.force, "radius": radius, "energy": jump.energy}
        attributes |= {f"{jump.kind}_{key}": value for key, value in values.items()}
    columns = _columns(case, quantity, approach, back, count)
    return dataset(columns, {"step": (np.arange(columns["depth"][1].size), {})}, attributes)


def contact_energy(case: AdhesiveCase, radius: Array) -> Array:
    """Energy E of adhesive contacts against separated bodies [J], at radii of shape (n,).

    Non-round tips and finite ranges of action: along equilibria dE = F dd, from nothing.
    """
    if not case.indenter.round or case.branch.range_of_action > 0:

        def work(r: Array) -> Array:
            contact = case.branch.at(r)
            return np.asarray(contact.force * contact.depth_slope)

        return _up_to(work, radius, case.branch.kinks)
    contact = case.branch.at(radius)
    plain, back = contact.plain, contact.retraction
    elastic = -plain.force * back + plain.stiffness * back**2 / 2
    if not case.pinned:
        elastic = elastic + _pressing_energy(case, radius)
    return np.asarray(elastic - np.pi * radius**2 * case.branch.work)


def _pressing_energy(case: AdhesiveCase, radius: Array) -> Array:
    """U_n = int F_n dd_n up to each radius."""

    def rate(r: Array) -> Array:
        plain = case.branch.evaluate(r)
        return np.asarray(plain.force * plain.depth_slope)

    return _up_to(rate, radius, case.branch.kinks)


def _up_to(rate: Callable[[Array], Array], radius: Array, kinks: tuple[float, ...]) -> Array:
    """int rate dln a from zero to each radius: Gauss rules on decades; the part below 1e-10 of the radius is negligible.

    Beyond kinks the rate is a series in the root of the distance.
    """
    t, weights = gauss()
    share, decades = (1 + t) / 2, np.log(10) * np.arange(-10, 1)
    ends = np.sort(
        np.clip(
            np.c_[np.log(radius)[:, None] + decades, np.tile(np.log(kinks), (radius.size, 1))],
            -np.inf,
            np.log(radius)[:, None],
        )
    )
    width = np.diff(ends)[..., None]
    x = ends[:, :-1, None] + width * share**2
    return np.asarray(np.sum(rate(np.exp(x).ravel()).reshape(x.shape) * width * share * weights, axis=(1, 2)))


def _path(case: AdhesiveCase, quantity: Quantity, most: float) -> tuple[list[_Leg], list[_Leg], list[Jump]]:
    # inner stretches first; the flat end's own edge is outside them all
    stretches: list[Stretch | None] = [*case.stability.of(quantity)[::-1]]
    if case.pinned:
        stretches.append(None)
    ends = [_ends(case, stretch, quantity) for stretch in stretches]
    at = -case.branch.range_of_action if quantity == "depth" else 0.0
    here = next(i for i, (low, high) in enumerate(ends) if low <= at <= high)
    first, energy = _state(case, stretches[here], quantity, at)
    jumps = [Jump("jump_in", first.depth, first.force, 0.0, first.radius, -energy)]
    approach = []
    while ends[here][1] < most:
        top = ends[here][1]
        approach.append(_Leg(stretches[here], at, top))
        further = next(i for i in range(here + 1, len(ends)) if ends[i][0] <= top <= ends[i][1])
        jumps.append(_jump(case, quantity, "outwards", stretches[here], stretches[further], top))
        here, at = further, top
    approach.append(_Leg(stretches[here], at, most))
    back, at = [], most
    while True:
        low = ends[here][0]
        back.append(_Leg(stretches[here], at, low))
        inner = [i for i in range(here - 1, -1, -1) if ends[i][0] < low <= ends[i][1]]
        if not inner:
            break
        if stretches[here] is not None or _radius(case, stretches[inner[0]], quantity, low) < case.indenter.reach * (
            1 - 1e-9
        ):
            jumps.append(_jump(case, quantity, "inwards", stretches[here], stretches[inner[0]], low))
        here, at = inner[0], low
    last, energy = _state(case, stretches[here], quantity, low)
    jumps.append(Jump("pull_off", last.depth, last.force, last.radius, 0.0, energy))
    return approach, back, jumps


def _ends(case: AdhesiveCase, stretch: Stretch | None, quantity: Quantity) -> tuple[float, float]:
    low, high = ends_of(case.branch, stretch, quantity) if stretch is not None else (-np.inf, np.inf)
    if not case.pinned:
        return low, high
    edge = float(value_of(case.branch.at(np.array([case.indenter.reach])), quantity)[0])
    return (edge, high) if stretch is None else (low, min(high, edge))


def _radius(case: AdhesiveCase, stretch: Stretch | None, quantity: Quantity, value: float) -> float:
    if stretch is None:
        return case.indenter.reach
    return float(radius_on(case, stretch, quantity, np.array([value]))[0])


def _state(case: AdhesiveCase, stretch: Stretch | None, quantity: Quantity, value: float) -> tuple[Instability, float]:
    radius = np.array([_radius(case, stretch, quantity, value)])
    contact, mean_radius = case.branch.at(radius), float(case.branch.size(radius)[0][0])
    if stretch is None:
        stiffness = float(contact.plain.stiffness[0])
        depth = value if quantity == "depth" else value / stiffness
        energy = stiffness * depth**2 / 2 - np.pi * radius[0] ** 2 * case.branch.work
        return Instability(stiffness * depth, depth, mean_radius), float(energy)
    depth = value if quantity == "depth" else float(contact.depth[0])
    force = value if quantity == "force" else float(contact.force[0])
    return Instability(force, depth, mean_radius), float(contact_energy(case, radius)[0])


def _jump(
    case: AdhesiveCase, quantity: Quantity, kind: str, old: Stretch | None, new: Stretch | None, value: float
) -> Jump:
    before, energy = _state(case, old, quantity, value)
    after, left = _state(case, new, quantity, value)
    lost = energy - left
    if quantity == "force":
        lost += value * (after.depth - before.depth)
    return Jump(kind, before.depth, before.force, before.radius, after.radius, lost)


def _columns(
    case: AdhesiveCase, quantity: Quantity, approach: list[_Leg], back: list[_Leg], count: int
) -> dict[str, Column]:
    """Separated approach, contact, withdrawal, one after the other."""
    legs = [_sample(case, quantity, leg, count) for leg in (*approach, *back)]
    first = -case.branch.range_of_action
    outside = np.linspace(1.2 * min(first, *(float(leg[0].min()) for leg in legs)), first, count)
    lead = (outside, *np.zeros((3, count)))
    depth, force, radius, area = (np.concatenate(parts) for parts in zip(lead, *legs, strict=True))
    columns = {
        "depth": (depth, "m", "indentation depth"),
        "force": (force, "N", "normal force"),
        "radius": (radius, "m", "mean contact radius a0"),
        "area": (area, "m^2", "contact area"),
    }
    data: dict[str, Column] = {
        name: ("step", values, {"units": unit, "long_name": text}) for name, (values, unit, text) in columns.items()
    }
    way = np.repeat([0, 1], [count * (1 + len(approach)), count * len(back)])
    data["branch"] = ("step", way, {"long_name": "0 approach, 1 withdrawal"})
    return data


def _sample(case: AdhesiveCase, quantity: Quantity, leg: _Leg, count: int) -> tuple[Array, Array, Array, Array]:
    wanted = np.linspace(leg.start, leg.end, count)
    if leg.stretch is None:
        radius = np.full(count, case.indenter.reach)
        stiffness = case.branch.evaluate(radius[:1]).stiffness[0]
        size = case.branch.size(radius)
        return (wanted, stiffness * wanted, *size) if quantity == "depth" else (wanted / stiffness, wanted, *size)
    radius = radius_on(case, leg.stretch, quantity, wanted)
    contact, size = case.branch.at(radius), case.branch.size(radius)
    return (wanted, contact.force, *size) if quantity == "depth" else (contact.depth, wanted, *size)
