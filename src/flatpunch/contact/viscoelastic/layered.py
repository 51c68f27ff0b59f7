"""Round contacts on layers and bases that relax each in its own way, any history of depth or force.

In the Laplace plane every modulus is multiplied by s psi(s); the compliance C(k, s) of the stack is that of an elastic one with
these moduli, and in time a sum over retardation times T, k C = 2 D, D = D_0(k) + sum D_T(k) (1 - exp(-t/T)). D_T is fitted at
real s, on times that are dense enough for any retardation between them (1e-5). With the pressure as ring sources,
P(k, t) = int g(x, t) cos(kx) dx, contact at x < a(t) reads

    (d(t) - w(x))/2 = int D(k, t - t') cos(kx) dP(k, t') dk,     g = 0 at x > a(t),

where w(x) is the depth at which a half-space touches at x. The part of short waves acts at x alone, (pi/2) D(inf); what layers
add is smooth. On rings of equal width g is linear in time between steps, the memory of each T decays exactly, and contact is the
set of rings up to one at which g stays positive: it may grow and shrink as often as it likes. The error is estimated with half as
many rings and steps, and fewer retardation times.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import NOTABLE_FORCE, Control, Curve
from flatpunch.contact.exact import punch_stiffness
from flatpunch.contact.round.mean_profile import mean_contact, mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.contact.viscoelastic.history import Relaxations, with_moduli
from flatpunch.indenters.profile import Indenter
from flatpunch.media import (
    HalfSpace,
    Prony,
    Stack,
)
from flatpunch.numerics.gauss import gauss

_RINGS, _STEPS, _PER_DECADE = 160, 400, 6
"""Rings of the largest contact, time steps of the history, and retardation times in a decade."""

_EDGE = 30.0
"""Times beyond the relaxation times at which retardations are looked for, and beyond the history: flow looks like these."""

_FLOW = 1e4
"""Retardation time that stands for flow, over the largest other one."""

_MOST = 30_000
"""Largest number of wavenumbers: contacts of some hundred thicknesses of the top layer."""


def _operational(relaxation: Prony | None, s: float) -> float:
    if relaxation is None:
        return 1.0
    turn = s * np.array(relaxation.times)
    return float(relaxation.equilibrium + np.array(relaxation.weights) @ (turn / (1 + turn)))


@dataclass(frozen=True)
class _Flexibility:
    """Rings and what they do to each other: matrices of the instantaneous response, and of each retardation time.

    Attributes
    ----------
    x : ndarray, shape (n,)
        Middles of the rings [m].
    width : float
        Their width [m].
    times : ndarray, shape (m,)
        Retardation times [s].
    matrices : ndarray, shape (m + 1, n, n)
        Half the displacement that enters the contact condition, per g [1/Pa].
    """

    x: Array
    width: float
    times: Array
    matrices: Array

    @classmethod
    def of(
        cls, medium: Stack, relaxing: Relaxations, radius: float, span: float, rings: int, per_decade: int
    ) -> _Flexibility:
        width = radius / rings
        x = width * (np.arange(rings, dtype=float) + 0.5)
        k, weight = _wavenumbers(medium, radius)
        known = np.concatenate([each.times for each in relaxing if each is not None] or [(span,)])
        low, high = known.min() / _EDGE, _EDGE * max(known.max(), span)
        times = low * 10 ** (np.arange(int(per_decade * np.log10(high / low)) + 2, dtype=float) / per_decade)
        # not down to 1 / high: there flow differs from long retardations, which a history of this length does not show
        s = np.geomspace(0.1 * _EDGE / high, 10 / low, 2 * times.size + 1)
        compliances = np.empty((s.size, k.size + 1))
        for i, each in enumerate(s.tolist()):
            body = with_moduli(medium, [_operational(one, each) for one in relaxing])
            compliances[i, 0] = 1 / body.surface_modulus
            compliances[i, 1:] = k * compliance(body)(k) / 2 - compliances[i, 0]
        # layers that flow: their retardation lasts far beyond the history
        times = np.append(times, _FLOW * high)
        basis = np.concatenate([np.ones((s.size, 1)), 1 / (1 + np.outer(s, times))], axis=1)
        # relative errors, of rows that differ by orders of magnitude where layers flow
        row, column = np.abs(compliances).max(axis=1), np.abs(basis).max(axis=0)
        balanced = basis / row[:, None] / column
        fitted = np.linalg.lstsq(balanced, compliances / row[:, None], rcond=1e-10)[0] / column[:, None]
        waves = np.cos(np.outer(x, k))
        matrices = np.stack([(waves * (weight * each[1:])) @ waves.T * width for each in fitted])
        matrices[:, np.arange(rings), np.arange(rings)] += np.pi / 2 * fitted[:, :1]
        return cls(x, width, times, matrices)


def _wavenumbers(medium: Stack, radius: float) -> tuple[Array, Array]:
    """Gauss nodes and weights over all wavenumbers at which layers add to the surface material."""
    kernel = compliance(medium)
    last = kernel.cutoff / kernel.length
    x, w = gauss()
    # phase of cos(kx) over a panel at the edge
    widest, edges = 10 / radius, [0.0, 1e-4 / max(radius, medium.thickness)]
    if last / widest * x.size > _MOST:
        raise ValueError(
            f"the contact, up to {text(radius, 'm')} wide, is too large against the top layer of {text(medium.length, 'm')} for "
            "layers that relax each in its own way. Leave out or join thin layers at the surface."
        )
    while edges[-1] < last:
        edges.append(min(edges[-1] + min(edges[-1], widest), last))
    half = np.diff(edges)[:, None] / 2
    return (np.array(edges[:-1])[:, None] + half * (1 + x)).ravel(), (half * w).ravel()


@dataclass
class _State:
    """g of all rings [Pa], memory of each retardation time, and rings in contact."""

    g: Array
    memory: Array
    contact: int


def _march(
    flexibility: _Flexibility, touch: Array, flat: bool, control: Control, time: Array, substeps: int, every: int
) -> tuple[Array, Array, Array, bool]:
    """Depth [m], force [N] and radius [m] at every so many substeps, and whether the contact stayed within the rings."""
    n = flexibility.x.size
    state = _State(np.zeros(n), np.zeros((flexibility.times.size, n)), 0)
    depth, force, radius = np.zeros((3, (time.size - 1) * (substeps // every) + 1))
    inside = True
    instant = flexibility.matrices[0]
    first = control.values[0]
    if first > 0:
        g, depth[0], state.contact = _solve(
            instant, np.zeros(n), touch, flat, control.name, first, flexibility.width, 0
        )
        state.g, state.memory = g, np.repeat(g[None], flexibility.times.size, axis=0)
    elif control.name == "depth":
        depth[0] = first
    force[0], radius[0] = 2 * np.pi * state.g.sum() * flexibility.width, _edge(flexibility, state)
    known: dict[float, tuple[Array, Array, Array]] = {}
    for j in range(1, time.size):
        step = (time[j] - time[j - 1]) / substeps
        if step not in known:
            decay = np.exp(-step / flexibility.times)
            gain = -np.expm1(-step / flexibility.times) * flexibility.times / step
            known[step] = decay, gain, instant + np.tensordot(1 - gain, flexibility.matrices[1:], axes=1)
        decay, gain, matrix = known[step]
        for i in range(1, substeps + 1):
            target = control.values[j - 1] + (control.values[j] - control.values[j - 1]) * i / substeps
            kept = decay[:, None] * state.memory - gain[:, None] * state.g
            history = -np.einsum("mij,mj->i", flexibility.matrices[1:], kept)
            g, reached, state.contact = _solve(
                matrix, history, touch, flat, control.name, target, flexibility.width, state.contact
            )
            state.memory = kept + gain[:, None] * g
            state.g = g
            inside &= flat or state.contact < n
            at, rest = divmod((j - 1) * substeps + i, every)
            if not rest:
                depth[at] = reached
                force[at], radius[at] = 2 * np.pi * state.g.sum() * flexibility.width, _edge(flexibility, state)
    return depth, force, radius, inside


def _solve(
    matrix: Array, history: Array, touch: Array, flat: bool, name: str, target: float, width: float, contact: int
) -> tuple[Array, float, int]:
    """g, depth and rings in contact at the end of a step; `history` is half the displacement that the past leaves."""
    n = touch.size
    contact = n if flat else max(contact, 1)
    moved = 0
    while True:
        sides = np.stack([np.full(contact, 0.5), -touch[:contact] / 2 - history[:contact]], axis=1)
        per_depth, rest = np.linalg.solve(matrix[:contact, :contact], sides).T
        if name == "depth":
            depth = target
        else:
            depth = (target / (2 * np.pi * width) - rest.sum()) / per_depth.sum()
        g = per_depth * depth + rest
        if flat:
            if name == "depth" and g.sum() <= 0:
                return np.zeros(n), depth, 0
            break
        # rings join where the tip is below the surface and leave where they would pull; a direction is kept
        if g[-1] < 0 and moved <= 0:
            contact, moved = contact - 1, -1
            if contact == 0:
                # the tip is free, or just touches the surface that recovers
                return np.zeros(n), float(depth if name == "depth" else touch[0] + 2 * history[0]), 0
            continue
        if contact < n and moved >= 0:
            gap = (depth - touch[contact]) / 2 - history[contact] - matrix[contact, :contact] @ g
            if gap > 0:
                contact, moved = contact + 1, 1
                continue
        break
    full = np.zeros(n)
    full[:contact] = g
    return full, float(depth), contact


def _edge(flexibility: _Flexibility, state: _State) -> float:
    """Contact radius: where g, extrapolated from the last two rings, is zero."""
    n = state.contact
    if n < 2:
        return float(n * flexibility.width)
    last, before = state.g[n - 1], state.g[n - 2]
    beyond = last / (before - last) if before > last else 0.5
    return float(flexibility.x[n - 1] + flexibility.width * min(max(beyond, 0.0), 1.0))


@dataclass(frozen=True, eq=False)
class _Case:
    """A history, with rings up to the `largest` radius [m]."""

    medium: Stack
    indenter: Indenter
    control: Control
    time: Array
    relaxing: Relaxations
    largest: float


def solve_layered(
    medium: Stack, indenter: Indenter, control: Control, time: Array, relaxing: Relaxations, phi: Array
) -> Curve:
    """Follow a history of depths [m] or forces [N] at ascending times [s], linear in between, of a round tip.

    `relaxing` has psi(t) of each layer and the base, whose moduli times psi relax; `phi` are polar angles of the outline [rad].
    """
    if not (control.values > 0).any():
        raise ValueError(f"{control.name} is nowhere positive, so there is never a contact.")
    instant = [1.0 if each is None else float(each(np.zeros(1))[0]) for each in relaxing]
    glassy = compliance(with_moduli(medium, instant))
    largest = _largest_radius(medium, indenter, control, instant, relaxing, time)
    while True:
        case = _Case(medium, indenter, control, time, relaxing, largest)
        fine, rough = _run(case, 1), _run(case, 2)
        if fine.inside and rough.inside:
            break
        largest *= 1.5
        if largest > indenter.reach:
            raise ValueError(
                f"the contact grows beyond this indenter, whose shape is defined up to {text(indenter.reach, 'm')}. Ask for "
                "less, or give the shape further out."
            )
    touching = fine.radius > 0
    stiffness = np.zeros(touching.size)
    if touching.any():
        stiffness[touching] = punch_stiffness(glassy, fine.radius[touching])
    # an error of the depth is that of the force which it would need
    apart = np.maximum.accumulate(np.abs(fine.force - rough.force) + stiffness * np.abs(fine.depth - rough.depth))
    error = apart / np.where(fine.force > 0, fine.force, np.abs(fine.force).max())
    # the difference vanishes by chance where the edge is at the same place within a ring: it counts between the given times too
    given = slice(None, None, (error.size - 1) // (time.size - 1))
    found = _Response(fine.depth[given], fine.force[given], fine.radius[given], fine.inside)
    error = np.maximum(error[given], _error_of_rings(case, instant, given))
    return _as_curve(found, stiffness[given], error, time, phi)


def _error_of_rings(case: _Case, instant: list[float], given: slice) -> Array:
    """Relative error of the force of the same rings on the body before it relaxes, whose exact contact is known, shape (n,).

    Thin incompressible layers under wide contacts hardly yield to a single ring: both solutions are then wrong alike.
    """
    stiff, control = with_moduli(case.medium, instant), case.control
    rings = _run(replace(case, medium=stiff, relaxing=(None,) * len(case.relaxing)), 2)
    touching = control.values > 0
    depth, force, slope = _elastic(compliance(stiff), case.indenter, Control(control.name, control.values[touching]))
    error = np.zeros(case.time.size)
    found = rings.force[given][touching]
    off = np.maximum.accumulate(np.abs(found - force) + slope * np.abs(rings.depth[given][touching] - depth))
    # over the smaller one, so that a force that is far too small is not known either
    error[touching] = off / np.where(found > 0, np.minimum(found, force), force)
    return error


def _elastic(kernel: Kernel, indenter: Indenter, control: Control) -> tuple[Array, Array, Array]:
    if indenter.flat:
        stiffness = np.full(control.values.size, punch_stiffness(kernel, np.array([indenter.reach]))[0])
        depth = control.values if control.name == "depth" else control.values / stiffness
        return depth, stiffness * depth, stiffness
    _, contact = mean_contact(kernel, indenter, control)
    return contact.depth, contact.force, contact.stiffness


@dataclass(frozen=True)
class _Response:
    """Depth [m], force [N] and radius [m] at the longest steps, and whether the contact stayed within the rings."""

    depth: Array
    force: Array
    radius: Array
    inside: bool


def _largest_radius(
    medium: Stack, indenter: Indenter, control: Control, instant: list[float], relaxing: Relaxations, time: Array
) -> float:
    """Largest contact radius that elastic bodies with the first and the last moduli have [m]."""
    if indenter.flat:
        return indenter.reach
    span = np.array([time[-1] - time[0]])
    final = [1.0 if each is None else max(float(each(span)[0]), 1e-6) for each in relaxing]
    most = Control(control.name, control.values.max(keepdims=True))
    found = [mean_contact(compliance(with_moduli(medium, each)), indenter, most)[1].radius for each in (instant, final)]
    return 1.05 * float(np.max(found))


def _run(case: _Case, coarser: int) -> _Response:
    """One solution; `coarser` divides rings, steps and retardation times."""
    rings, per_decade = _RINGS // coarser, _PER_DECADE - (coarser > 1)
    span = float(case.time[-1] - case.time[0])
    flexibility = _Flexibility.of(case.medium, case.relaxing, case.largest, span, rings, per_decade)
    flat = case.indenter.flat
    touch = np.zeros(flexibility.x.size)
    if not flat:
        touch = round_contact(compliance(HalfSpace(1.0, 0.0)), mean_profile(case.indenter), flexibility.x).depth
    every = 2 // coarser
    substeps = every * -(-_STEPS // (2 * (case.time.size - 1)))
    return _Response(*_march(flexibility, touch, flat, case.control, case.time, substeps, every))


def _as_curve(found: _Response, stiffness: Array, error: Array, time: Array, phi: Array) -> Curve:
    notes: tuple[str, ...] = ()
    worst = float(error[found.force > 0].max(initial=0.0))
    if worst > NOTABLE_FORCE:
        notes = (
            f"The numerical error of the history reaches {worst:.2g} of the force: see force_error, and give more times.",
        )
    return Curve(
        depth=found.depth,
        force=found.force,
        radius=found.radius,
        area=np.pi * found.radius**2,
        stiffness=stiffness,
        contour=np.repeat(found.radius[:, None], phi.size, axis=1),
        valid=np.ones(time.size, dtype=bool),
        notes=notes,
        extra={
            "time": (("step",), time, "s", "time"),
            "force_error": (("step",), error, "1", "estimated relative error of the force"),
        },
    )
